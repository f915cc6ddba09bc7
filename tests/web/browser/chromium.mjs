// The browser of the tests and of latency.mjs.
import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

const executablePath = [process.env.CLERESTORY_CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"]
  .find((path) => path && existsSync(path));
export const isInstalled = executablePath !== undefined;
export const launch = () => chromium.launch({ executablePath, args: ["--no-sandbox"] });
