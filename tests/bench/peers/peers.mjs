// scripts/bench peers: frames of three.js in Node and of a Clerestory server in turns, and the ratio of their times.
import { mkdirSync, writeFileSync } from 'node:fs';
import { loadavg, cpus } from 'node:os';
import { join, resolve } from 'node:path';
import { parseArgs } from 'node:util';
import { findScenes, sceneOfFile, poseOf, skyRadiance, skySize, writeSky } from './scenes.mjs';
import { Peer } from './peer.mjs';
import { Server } from './server.mjs';

const kUsage = `usage: scripts/bench peers [--size WxH --frames N --scene NAME --mode base|all|full --single-process --json FILE]
  --size WxH         64x64 to 4096x2160; 1280x720
  --frames N         measured frames of each renderer, scene and mode, 1 to 1000; 21
  --scene NAME       room, hall, Sponza, FlightHelmet, or a glTF file; may be repeated; all that are available
  --mode MODE        base: no effects; all: the four effects; full: shadows and light between surfaces as well;
                     may be repeated; all three
  --single-process   Clerestory draws in the process of the server
  --json FILE        also writes every measured time`;

const kWarmUp = 6;  // frames of each kind before those that are measured
const kPresets = ['draft', 'standard'];
const kModes = ['base', 'all', 'full'];

function fail(text) {
  console.error(`${text}\n${kUsage}`);
  process.exit(2);
}

function readOptions() {
  const text = { type: 'string' }, list = { type: 'string', multiple: true };
  let values;
  try {
    ({ values } = parseArgs({ options: { bin: text, shared: text, output: text, size: text, frames: text, scene: list, mode: list,
      json: text, 'single-process': { type: 'boolean' }, help: { type: 'boolean' } } }));
  } catch (error) {
    fail(error.message);
  }
  if (values.help) {
    console.log(kUsage);
    process.exit(0);
  }
  const [, width, height] = (/^(\d{2,4})x(\d{2,4})$/.exec(values.size ?? '1280x720') ?? []).map(Number);
  if (!(width >= 64 && width <= 4096 && height >= 64 && height <= 2160)) fail('--size is 64x64 to 4096x2160');
  const frames = Number(values.frames ?? 21);
  if (!(Number.isInteger(frames) && frames >= 1 && frames <= 1000)) fail('--frames is 1 to 1000');
  for (const mode of values.mode ?? []) if (!kModes.includes(mode)) fail('--mode is base, all or full');
  return { ...values, size: { width, height }, frames, modes: values.mode ?? kModes };
}

const median = (values) => {
  const sorted = values.toSorted((a, b) => a - b), middle = sorted.length >> 1;
  return sorted.length % 2 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
};
const medianOf = (frames, field) => median(frames.map((frame) => frame[field] ?? 0));
const digits = (value, count = 0) => value.toFixed(count);

function printTable(heads, rows) {
  const widths = heads.map((head, k) => Math.max(head.length, ...rows.map((row) => row[k].length)));
  for (const row of [heads, ...rows]) {
    console.log(row.map((cell, k) => (k < 2 ? cell.padEnd(widths[k]) : cell.padStart(widths[k]))).join('  ').trimEnd());
  }
}

// Frames of one scene and mode. The renderers take turns frame by frame and draw the same pose.
async function measure({ peer, server, view, mode, frames, keep }) {
  const sides = { peer: (pose) => peer.frame(pose), ...Object.fromEntries(kPresets.map((preset) =>
    [preset, (pose) => server.frame(pose, mode, preset)])) };
  const names = Object.keys(sides), measured = Object.fromEntries(names.map((name) => [name, []]));
  peer.setMode(mode);
  await server.completeLight(view, mode);
  for (let index = 0; index < kWarmUp + frames; ++index) {
    const pose = poseOf(view, index);
    for (let turn = 0; turn < names.length; ++turn) {
      const name = names[(index + turn) % names.length];
      const { picture, ...times } = await sides[name](pose);
      if (index === 0) keep(name, picture);
      if (index >= kWarmUp) measured[name].push(times);
    }
  }
  return measured;
}

async function main() {
  const options = readOptions();
  const folder = resolve(options.output);
  mkdirSync(folder, { recursive: true });
  const sky = join(folder, 'sky-of-bench.hdr');
  writeSky(sky);
  const known = findScenes({ bin: options.bin, shared: options.shared, folder });
  const scenes = options.scene?.map((name) => known.find((scene) => scene.name === name) ?? sceneOfFile(name) ??
    fail(`--scene ${name} is neither a glTF file nor one of ${known.map((s) => s.name).join(', ')}`)) ?? known;

  const results = [];
  for (const scene of scenes) {
    process.stderr.write(`measuring ${scene.name}\n`);
    const server = await Server.start({ program: join(options.bin, 'clerestory'), scene: scene.file, sky, size: options.size,
      single: options['single-process'] });
    try {
      const view = { ...server.view, ...scene.camera };
      const peer = await Peer.create({ scene: scene.file, size: options.size, sky: skyRadiance, skySize });
      for (const mode of options.modes) {
        const before = loadavg()[0];
        const keep = (name, picture) => writeFileSync(join(folder, `${scene.name}-${mode}-${name}.jpg`), picture);
        const measured = await measure({ peer, server, view, mode, frames: options.frames, keep });
        results.push({ scene: scene.name, mode, targets: scene.targets[mode], load: [before, loadavg()[0]], ...measured });
      }
      if (scene === scenes[0]) {
        const { renderer, version } = await server.driver();
        console.log(`three.js r187, headless-gl: ${peer.driver}\nClerestory, ${options['single-process'] ? 'one process' :
          'renderer process'}: ${renderer}, ${version}`);
      }
      peer.close();
    } finally {
      await server.stop();
    }
  }
  report(results, options);
  if (options.json) writeFileSync(options.json, JSON.stringify({ size: options.size, processors: cpus().length, results }, null, 1));
  console.log(`pictures of every row: ${folder}`);
}

function report(results, { size, frames }) {
  console.log(`\n${size.width}x${size.height}, ${cpus().length} processors, medians of ${frames} frames in turns, milliseconds from pose to JPEG; ` +
    'ratio: Clerestory / peer; ! misses its target\n' +
    'by round: medians of the ratios of each round; of minima: ratios of the least times (draft, standard); load: before and after');
  const ratio = (value, target) => `${digits(value, 2)}${value > target ? ' !' : '  '}`;
  printTable(['scene', 'mode', 'peer', ...kPresets.flatMap((p) => [p, 'ratio  ', 'target']), 'by round', 'of minima', 'load'], results.map((row) => {
    const peer = medianOf(row.peer, 'total'), least = (name) => Math.min(...row[name].map((frame) => frame.total));
    const both = (ratioOf) => kPresets.map((preset) => digits(ratioOf(preset), 2)).join(' ');
    return [row.scene, row.mode, digits(peer), ...kPresets.flatMap((preset) => {
      const own = medianOf(row[preset], 'total'), target = row.targets?.[preset];  // none for full
      return [digits(own), ratio(own / peer, target), target === undefined ? '-' : digits(target, 1)];
    }), both((preset) => median(row[preset].map((frame, k) => frame.total / row.peer[k].total))),
      both((preset) => least(preset) / least('peer')), row.load.map((x) => digits(x, 1)).join('-')];
  }));

  console.log('\nThe peer: milliseconds by part, least total, draws and triangles of a frame');
  printTable(['scene', 'mode', 'draw', 'read', 'encode', 'least', 'draws', 'triangles'], results.map((row) => [row.scene, row.mode,
    ...['draw', 'read', 'encode'].map((part) => digits(medianOf(row.peer, part), 1)), digits(Math.min(...row.peer.map((f) => f.total)), 1),
    ...['draws', 'triangles'].map((count) => digits(medianOf(row.peer, count)))]));

  console.log('\nClerestory: milliseconds by part of Server-Timing, least total');
  for (const row of results) {
    for (const preset of kPresets) {
      const parts = row[preset].map((frame) => frame.parts), names = [...new Set(parts.flatMap(Object.keys))];
      const list = names.map((name) => [name, medianOf(parts, name)]).filter(([name, value]) => name !== 'total' && value >= 0.5);
      console.log(`${row.scene} ${row.mode} ${preset}: ${list.map(([name, value]) => `${name} ${digits(value, 1)}`).join(', ')}; least ${
        digits(Math.min(...row[preset].map((frame) => frame.total)), 1)}`);
    }
  }
}

main().catch((error) => {
  console.error(`bench peers: ${error.message}`);
  process.exit(1);
});
