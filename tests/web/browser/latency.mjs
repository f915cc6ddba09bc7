// The page's latency in Chromium: from a move of the pointer to the first picture that was requested after it, and from the
// choice of a loaded scene to its first picture. Figures are printed, not asserted. `scripts/bench page` runs this.
//   node latency.mjs [SECONDS]   of dragging; CLERESTORY_PROGRAM is the server
import { killServers, patiently, serve } from "../server_process.mjs";
import { isInstalled, launch } from "./chromium.mjs";

const seconds = Number(process.argv[2] ?? 10);
if (!isInstalled) {
  console.error("no Chromium is installed; scripts/setup tests installs one");
  process.exit(2);
}

// Runs in the page before its own code.
function record() {
  const log = (window.latency = { moves: [], pictures: [] });
  let drawn;  // the last request whose response has arrived
  const real = window.fetch;
  window.fetch = async (path, options) => {
    const isFrame = String(path).startsWith("v1/frames") && options?.method === "POST";
    const sent = performance.now();
    const response = await real(path, options);
    if (isFrame && response.ok) {
      const { width, height, scene } = JSON.parse(options.body);
      drawn = { sent, width, height, scene };
    }
    return response;
  };
  addEventListener("pointermove", (e) => e.buttons && log.moves.push(performance.now()), true);
  addEventListener("DOMContentLoaded", () => document.querySelector("#frame").addEventListener("load", () => {
    if (drawn) log.pictures.push({ ...drawn, shown: performance.now() });
  }));
}

const quantile = (values, q) => values.toSorted((a, b) => a - b)[Math.min(values.length - 1, Math.floor(q * values.length))];
const milliseconds = (values) => `p50 ${quantile(values, 0.5).toFixed(0)} ms, p95 ${quantile(values, 0.95).toFixed(0)} ms`;
const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// The renderer that starts with shaders compiled without optimisation is replaced, and light between surfaces is computed, in the
// first half minute; the figures are those of the time after it.
async function lightIsComplete(scene) {
  for (;;) {
    const { light, shaders } = await (await patiently(new URL(`v1/scenes/${scene}`, server.url))).json();
    const { shaders: compiled } = await (await patiently(new URL("v1/renderer", server.url))).json();
    if (light?.share === 1 && shaders.finished && compiled.optimized) return;
    await pause(500);
  }
}

const server = await serve({ scenes: ["chapel", "teapots"] });
const browser = await launch();
try {
  const page = await (await browser.newContext({ viewport: { width: 1280, height: 800 } })).newPage();
  page.setDefaultTimeout(600000);
  await page.addInitScript(record);
  await page.goto(server.url);
  const settled = () => page.waitForFunction(() => document.querySelector("#frame").src && document.querySelector("#note").hidden &&
    !document.querySelector("#stage").classList.contains("moving") && performance.now() - (window.latency.pictures.at(-1)?.shown ?? 1e9) > 2000);
  await lightIsComplete("chapel");
  await settled();

  // A drag of a person: the pointer moves every 16 ms, back and forth.
  const box = await page.locator("#stage").boundingBox();
  const x = box.x + box.width / 2, y = box.y + box.height / 2;
  await page.mouse.move(x, y);
  await page.mouse.down();
  const start = performance.now();
  for (let t = 0; t < seconds; t = (performance.now() - start) / 1000) {
    await Promise.all([page.mouse.move(x + 150 * Math.sin(t), y + 40 * Math.sin(0.7 * t)), pause(16)]);
  }
  const log = await page.evaluate(() => structuredClone(window.latency));
  await page.mouse.up();
  const moved = log.moves.flatMap((at) => {
    const picture = log.pictures.find(({ sent }) => sent >= at);
    return picture ? [picture.shown - at] : [];
  });
  const drawn = log.pictures.filter(({ sent }) => sent >= log.moves[0]);
  const sizes = [...new Set(drawn.map(({ width, height }) => `${width}x${height}`))];
  console.log(`drag in chapel, ${box.width.toFixed(0)}x${box.height.toFixed(0)}: ${moved.length} moves, ${milliseconds(moved)}; ` +
              `${(drawn.length / seconds).toFixed(1)} pictures per second of ${sizes.join(", ")}`);

  const switches = [];
  for (const scene of ["teapots", "chapel", "teapots", "chapel", "teapots", "chapel"]) {
    await settled();
    const at = await page.evaluate(() => performance.now());
    await page.selectOption("#scene", scene);
    const shown = await page.waitForFunction(({ at, scene }) =>
      window.latency.pictures.find((p) => p.sent >= at && p.scene === scene)?.shown, { at, scene });
    switches.push(await shown.jsonValue() - at);
  }
  console.log(`switch between loaded scenes to the first picture: ${switches.slice(1).map((ms) => ms.toFixed(0)).join(", ")} ms`);
} finally {
  await browser.close();
  await server.stop();
  killServers();
}
