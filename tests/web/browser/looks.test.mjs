// Pictures of the page, to be looked at, and words that must fit.
import assert from "node:assert/strict";

import { visit } from "./support.mjs";

const looks = [
  ["desk-light", { colorScheme: "light", viewport: { width: 1360, height: 850 } }],
  ["desk-dark", { colorScheme: "dark", viewport: { width: 1360, height: 850 } }],
  ["phone-light", { colorScheme: "light", viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 }],
  ["phone-dark", { colorScheme: "dark", viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 }],
];
for (const [name, options] of looks) {
  visit(`it looks well: ${name}`, { ...options, path: "#scene=chapel" }, async (v, page) => {
    for (const tab of ["view", "accuracy", "cost", "compare", "maps"]) {
      await page.click(`#tab-${tab}`);
      if (tab === "maps") {
        await page.click("#maps-show");
        await page.waitForFunction(() => [...document.querySelectorAll("#maps img")].every((i) => i.naturalWidth > 0) &&
          document.querySelectorAll("#maps img").length > 2);
      }
      await v.picture(`${name}-${tab}`);
      const cut = await page.evaluate(() => [...document.querySelectorAll("aside button, aside label, aside h2, header label")]
        .filter((e) => e.offsetParent && e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).display !== "inline").map((e) => e.textContent));
      assert.deepEqual(cut, [], "words that do not fit");
    }
  });
}
