// The OpenAPI document of a running server passes Redocly's lint, and a TypeScript client that is generated from it draws
// a frame.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";

import { killServers, patiently, serve } from "../server_process.mjs";

const folder = mkdtempSync(join(tmpdir(), "clerestory-client-"));
const tool = (path) => join(import.meta.dirname, "node_modules", path);
const run = (program, ...flags) => {
  try {
    return execFileSync(process.execPath, [tool(program), ...flags], {
      cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"],
      env: { ...process.env, REDOCLY_TELEMETRY: "off", REDOCLY_SUPPRESS_UPDATE_NOTICE: "true" },
    });
  } catch ({ stdout, stderr }) {
    assert.fail(`${program} failed:\n${stdout}${stderr}`);
  }
};

let server;
before(async () => {
  server = await serve();
  await patiently(`${server.url}readyz`);
  writeFileSync(join(folder, "openapi.json"), await (await fetch(`${server.url}openapi.json`)).text());
});
after(async () => {
  await server?.stop();
  killServers();
  rmSync(folder, { recursive: true, force: true });
});

test("the document passes Redocly's recommended rules", () => {
  const { totals, problems } = JSON.parse(run("@redocly/cli/bin/cli.js", "lint", "--extends=recommended", "--format=json", "openapi.json"));
  assert.deepEqual(totals, { errors: 0, warnings: 0, ignored: 0 }, JSON.stringify(problems, null, 2));
});

test("a generated client draws a frame, reads a refusal and waits for a job", { timeout: 300000 }, async () => {
  copyFileSync(join(import.meta.dirname, "client.ts"), join(folder, "client.ts"));
  symlinkSync(tool(""), join(folder, "node_modules"));
  writeFileSync(join(folder, "package.json"), '{ "type": "module" }');
  // Without the flag a field with a default would be required in a request.
  run("openapi-typescript/bin/cli.js", "openapi.json", "--default-non-nullable=false", "--output", "clerestory.ts");
  run("typescript/bin/tsc", "--strict", "--noUncheckedIndexedAccess", "--target", "es2022", "--module", "nodenext", "--lib", "es2022,dom,dom.iterable",
      "client.ts");
  const { compare, drawFrame, refusedFields, smallFrame, wrongFrames } = await import(pathToFileURL(join(folder, "client.js")));
  const baseUrl = server.url.replace(/\/$/, "");

  const { kinds, jpeg } = await drawFrame(baseUrl, smallFrame);
  assert.ok(kinds.includes("twirl") && kinds.includes("toneMap"), `${kinds}`);
  const bytes = new Uint8Array(jpeg);
  assert.deepEqual([...bytes.subarray(0, 2), ...bytes.subarray(-2)], [0xff, 0xd8, 0xff, 0xd9]);

  assert.deepEqual(await Promise.all(wrongFrames.map((frame) => refusedFields(baseUrl, frame))), [
    { status: 422, code: "invalidFields", pointers: ["/filters/0/amount"] },
    { status: 422, code: "invalidFields", pointers: ["/filters/0/amount"] },
    { status: 422, code: "invalidFields", pointers: ["/accuracy"] },
  ]);

  const errors = await compare(baseUrl, smallFrame);
  assert.equal(errors.length, 2);
  assert.ok(errors.every((error) => error === null || error >= 0), `${errors}`);
});
