// Starts servers for tests: the program is CLERESTORY_PROGRAM.
import { spawn } from "node:child_process";
import { createServer } from "node:net";

const running = new Set();

// -> { url, stop() }; port 0 selects a free one.
export async function serve({ port = 0, scenes = ["six-walls"], more = [] } = {}) {
  const flags = ["serve", "--port", String(port), "--log-level", "warn", "--deadline", "60", "--scene-cache", "none", ...scenes.flatMap((s) => ["--scene", s]), ...more];
  const child = spawn(process.env.CLERESTORY_PROGRAM, flags, { stdio: ["ignore", "pipe", "inherit"] });
  running.add(child);
  child.on("exit", () => running.delete(child));
  const url = await new Promise((resolve, reject) => {
    let output = "";
    child.stdout.on("data", (text) => {
      output += text;
      const url = /http:\/\/\S+/.exec(output);
      if (url) resolve(url[0]);
    });
    child.on("exit", (code) => reject(new Error(`the server ended with ${code}`)));
  });
  const ended = new Promise((resolve) => child.on("exit", resolve));
  return { url, stop: () => (child.kill("SIGTERM"), ended) };
}

// Kills servers that a failed test did not stop; they would keep this process alive.
export function killServers() {
  for (const server of running) server.kill("SIGKILL");
}

// fetch() that retries as long as the response has a Retry-After.
export async function patiently(url, init) {
  for (;;) {
    const response = await fetch(url, init);
    const seconds = Number(response.headers.get("Retry-After"));
    if (![409, 503].includes(response.status) || !seconds) return response;
    await new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
  }
}

export async function freePort() {
  const server = createServer().listen(0, "127.0.0.1");
  await new Promise((resolve) => server.on("listening", resolve));
  const { port } = server.address();
  await new Promise((resolve) => server.close(resolve));
  return port;
}
