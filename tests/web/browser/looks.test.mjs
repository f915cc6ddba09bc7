// Screenshots of the page; text must fit and have enough contrast.
import assert from "node:assert/strict";

import { visit } from "./support.mjs";

// Runs in the page: text whose contrast is below WCAG 2.2, level AA: 4.5, or 3 for large text. Disabled controls are exempt.
function lowContrastText() {
  const numbers = (color) => color.match(/[\d.]+/g).map(Number);
  const light = (color) => {
    const [r, g, b] = numbers(color).map((c) => c / 255).map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = (element) => {
    for (let e = element; e; e = e.parentElement) {
      const color = getComputedStyle(e).backgroundColor;
      if ((numbers(color)[3] ?? 1) === 1) return color;
    }
    return "rgb(255, 255, 255)";
  };
  const found = [];
  let examined = 0;
  for (const e of document.querySelectorAll("header *, aside *")) {
    const words = [...e.childNodes].filter((n) => n.nodeType === Node.TEXT_NODE && n.textContent.trim()).map((n) => n.textContent.trim()).join(" ");
    const style = getComputedStyle(e);
    if (!words || !e.offsetParent || style.visibility === "hidden" || e.closest(":disabled, [aria-disabled=true], option, svg")) continue;
    ++examined;
    const [low, high] = [light(style.color), light(behind(e))].sort((a, b) => a - b);
    const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    const contrast = (high + 0.05) / (low + 0.05);
    if (contrast < (large ? 3 : 4.5)) found.push(`${words.slice(0, 40)}: ${contrast.toFixed(2)}`);
  }
  return { examined, found };
}

const looks = [
  ["desk-light", { colorScheme: "light", viewport: { width: 1360, height: 850 } }],
  ["desk-dark", { colorScheme: "dark", viewport: { width: 1360, height: 850 } }],
  ["tablet-light", { colorScheme: "light", viewport: { width: 820, height: 1180 }, hasTouch: true }],
  ["phone-light", { colorScheme: "light", viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 }],
  ["phone-dark", { colorScheme: "dark", viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 }],
];
for (const [name, options] of looks) {
  visit(`text fits and is legible: ${name}`, { ...options, path: "#scene=chapel" }, async (v, page) => {
    // Until its light is complete, the page requests the frame again now and then, also next to the maps.
    v.expected.push(/503/); // a busy machine does not draw the chapel in time, and the page tries again
    await page.waitForFunction(() => !document.querySelector("#caption").textContent.includes("light"), undefined, { timeout: 590_000 });
    await v.settled();
    for (const tab of ["view", "accuracy", "cost", "compare", "maps"]) {
      await page.click(`#tab-${tab}`);
      if (tab === "maps") {
        await page.click("#maps-show");
        // How many maps there are depends on the plan; that of the environment is always one of them.
        await page.waitForFunction(() => document.querySelector("#maps img") &&
          [...document.querySelectorAll("#maps img")].every((i) => i.naturalWidth > 0));
      }
      await v.screenshot(`${name}-${tab}`);
      const cut = await page.evaluate(() => [...document.querySelectorAll("aside button, aside label, aside h2, header label")]
        .filter((e) => e.offsetParent && e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).display !== "inline").map((e) => e.textContent));
      assert.deepEqual(cut, [], "text does not fit");
      const { examined, found } = await page.evaluate(lowContrastText);
      assert.ok(examined > 10);
      assert.deepEqual(found, [], "low contrast");
    }
  });
}
