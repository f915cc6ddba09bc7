// The scenes that both renderers draw, the camera of each frame and the sky that lights them.
import { existsSync, mkdirSync, writeFileSync } from 'node:fs';
import { execFileSync } from 'node:child_process';
import { basename, join, resolve } from 'node:path';

// Largest allowed time relative to the peer's, for the presets draft and standard.
const kRoomTargets = { base: { draft: 0.6, standard: 0.6 }, all: { draft: 0.6, standard: 1.2 } };
const kCourtTargets = { base: { draft: 0.4, standard: 0.4 }, all: { draft: 0.6, standard: 1.2 } };

// Writes the rooms with the program bench_room. A scene without `camera` is seen from its default view.
export function findScenes({ bin, shared, folder }) {
  const room = (name, ...size) => {
    const at = join(folder, name);
    mkdirSync(at, { recursive: true });
    return { name, file: execFileSync(join(bin, 'bench_room'), [at, ...size], { encoding: 'utf8' }).trim(), targets: kRoomTargets };
  };
  const found = [
    room('room'),
    room('hall', '16', '6'),
    { name: 'Sponza', file: join(shared, 'Sponza/Sponza.gltf'), targets: kCourtTargets,
      camera: { position: [8, 2.5, -0.3], target: [-8, 3.5, -0.3] } },
    { name: 'FlightHelmet', file: join(shared, 'FlightHelmet/FlightHelmet.gltf'), targets: kRoomTargets },
  ];
  return found.filter((scene) => existsSync(scene.file));
}

// A glTF file of the user's, which has no targets.
export function sceneOfFile(file) {
  return existsSync(file) && /\.gl(tf|b)$/.test(file) ? { name: basename(file).replace(/\.[^.]*$/, ''), file: resolve(file), targets: {} } : null;
}

// Frame `index` of a scene: the camera, moved by up to 3 % of the distance to its target. No two frames have the
// same pose, so that neither a cache of frames nor one of maps answers in place of the renderer.
export function poseOf(view, index) {
  const along = view.target.map((t, k) => t - view.position[k]);
  const distance = Math.hypot(...along);
  const share = (step) => ((index * step) % 1) - 0.5;
  const flat = Math.hypot(along[0], along[2]) || 1;
  const right = [-along[2] / flat, 0, along[0] / flat];
  const sideways = 0.06 * distance * share(0.61803399), upwards = 0.03 * distance * share(0.75487767);
  const moved = (point, part) => [point[0] + part * sideways * right[0], point[1] + part * upwards, point[2] + part * sideways * right[2]];
  return { position: moved(view.position, 1), target: moved(view.target, 0.3), yfov: view.yfov };
}

export const skySize = { width: 256, height: 128 };

// Radiance of the sky by the vertical component of the direction: the same from every side, without a sun.
export function skyRadiance(y) {
  const up = Math.max(y, 0), down = Math.min(1, Math.max(-y * 6, 0));
  const haze = (1 - up) ** 4;
  const sky = [0.16 + 0.5 * haze, 0.32 + 0.36 * haze, 0.7 + 0.1 * haze];
  return sky.map((c, k) => c * (1 - down) + [0.2, 0.18, 0.16][k] * down);
}

// An equirectangular image in the Radiance format, without compression; the first row is +Y.
export function writeSky(file) {
  const { width, height } = skySize;
  const texels = Buffer.alloc(width * height * 4);
  for (let row = 0; row < height; ++row) {
    const radiance = skyRadiance(Math.cos(Math.PI * (row + 0.5) / height));
    const exponent = Math.floor(Math.log2(Math.max(...radiance))) + 1;
    for (let column = 0; column < width; ++column) {
      const at = (row * width + column) * 4;
      radiance.forEach((c, k) => { texels[at + k] = Math.min(255, Math.floor(c * 2 ** (8 - exponent))); });
      texels[at + 3] = exponent + 128;
    }
  }
  writeFileSync(file, Buffer.concat([Buffer.from(`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`), texels]));
}
