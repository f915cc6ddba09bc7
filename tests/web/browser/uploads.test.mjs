// Files that become scenes: selected, dropped, several at once, folders, and those that are no scene.
import assert from "node:assert/strict";
import { mkdirSync, mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";

import { serve } from "../server_process.mjs";
import { Visit, text, visit } from "./support.mjs";

// One triangle of this width.
function glb(x = 1) {
  const binary = Buffer.from(triangle(x));
  const json = JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }], buffers: [{ byteLength: 36 }],
    bufferViews: [{ buffer: 0, byteLength: 36 }],
    accessors: [{ bufferView: 0, componentType: 5126, type: "VEC3", count: 3, min: [0, 0, 0], max: [1, 1, 0] }],
  });
  const text = Buffer.from(json.padEnd(Math.ceil(json.length / 4) * 4));
  const numbers = (...list) => Buffer.from(new Uint32Array(list).buffer);
  return Buffer.concat([Buffer.from("glTF"), numbers(2, 12 + 8 + text.length + 8 + 36, text.length), Buffer.from("JSON"), text,
                        numbers(36), Buffer.from("BIN\0"), binary]);
}

test("an uploaded file becomes a scene; an invalid file is reported and changes nothing", { timeout: 600000 }, async () => {
  const folder = mkdtempSync(join(tmpdir(), "clerestory-uploads-"));
  const open = await serve({ more: ["--uploads", folder, "--max-upload", "100000"] });
  const v = await Visit.open(open.url);
  v.expected.push(/415|422/);
  const { page } = v;
  await v.settled();
  const send = (name, buffer) => page.setInputFiles("#upload", { name, mimeType: "model/gltf-binary", buffer });
  const posted = page.waitForRequest((r) => r.method() === "POST" && r.url().includes("/v1/scenes"));
  await send("My triangle.glb", glb());
  assert.equal((await posted).headers()["content-type"], "model/gltf-binary");
  await page.waitForFunction(() => location.hash.includes("scene=upload-"));
  const id = (await v.settled()).scene;
  assert.match(id, /^upload-[0-9a-f]{32}$/);
  assert.equal(await page.locator("#scene option:checked").textContent(), "My triangle.glb");
  await v.screenshot("upload");

  const refusal = async (name, buffer, words) => {
    await send(name, buffer);
    await page.waitForFunction((w) => new RegExp(w, "s").test(document.querySelector("#note.bad")?.textContent ?? ""), words.source);
    await page.waitForFunction((stays) => document.querySelector("#scene").value === stays, id);
  };
  // A failed scene is no longer in the list when a slow response arrives.
  await page.route(/\/v1\/scenes$/, (route) => setTimeout(() => route.continue(), 500));
  await refusal("torn.glb", glb().subarray(0, 100), /differs from that in its header/);
  await refusal("hollow.zip", Buffer.from("PK\x03\x04 and no more"), /hollow.zip could not be opened/);
  await refusal("words.glb", Buffer.from("words"), /words.glb could not be opened.*Unsupported media type/);
  await refusal("huge.glb", Buffer.alloc(100001), /the limit of the server is 98 KB/);
  await v.leave();
  await open.stop();
});

// One triangle in a .gltf with its buffer in another file and a texture that is missing.
function gltf(buffer) {
  return JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], images: [{ uri: "gone.png" }], textures: [{ source: 0 }],
    materials: [{ name: "wood", pbrMetallicRoughness: { baseColorTexture: { index: 0 } } }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, material: 0 }] }], buffers: [{ byteLength: 36, uri: encodeURI(buffer) }],
    bufferViews: [{ buffer: 0, byteLength: 36 }],
    accessors: [{ bufferView: 0, componentType: 5126, type: "VEC3", count: 3, min: [0, 0, 0], max: [1, 1, 0] }],
  });
}
// A panorama of one colour, which is RGBE.
const hdr = (color) => Buffer.concat([Buffer.from("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n"), ...Array(32).fill(Buffer.from(color))]);
const triangle = (x) => [...new Uint8Array(new Float32Array([0, 0, 0, x, 0, 0, 0, 1, 0]).buffer)];

// Drops files on the page as a browser without folder entries does. files: [{ name, bytes or text }].
const drop = (page, files) => page.evaluate((all) => {
  const data = new DataTransfer();
  for (const { name, bytes, words } of all) data.items.add(new File([bytes ? new Uint8Array(bytes) : words], name));
  const fire = (type) => document.body.dispatchEvent(new DragEvent(type, { dataTransfer: data, bubbles: true, cancelable: true }));
  fire("dragenter");
  const highlighted = !document.querySelector("#drop").hidden;
  fire("drop");
  return highlighted && document.querySelector("#drop").hidden;
}, files);

async function withUploads(steps) {
  const open = await serve({ more: ["--uploads", mkdtempSync(join(tmpdir(), "clerestory-uploads-"))] });
  const v = await Visit.open(open.url);
  v.expected.push(/415|422/);
  await v.settled();
  await steps(v, v.page);
  await v.leave();
  await open.stop();
}
const shows = (page, title) => page.waitForFunction((t) =>
  document.querySelector("#scene").selectedOptions[0]?.textContent === t && !document.querySelector("#stage").classList.contains("busy"), title);

test("files are opened after others whose upload failed unexpectedly, which is in the console", { timeout: 600000 }, () =>
  withUploads(async (v, page) => {
    v.expected.push(/unexpected/);
    await page.evaluate(() => {
      const { send } = XMLHttpRequest.prototype;
      XMLHttpRequest.prototype.send = () => {
        XMLHttpRequest.prototype.send = send;
        throw new Error("unexpected");
      };
    });
    await drop(page, [{ name: "one.glb", bytes: [...glb(1)] }]);
    await drop(page, [{ name: "two.glb", bytes: [...glb(2)] }]);
    await shows(page, "two.glb");
    await v.settled();
    assert.ok(v.errors.some((error) => /unexpected/.test(error)), `${v.errors}`);
    assert.ok(!(await page.locator("#scene option").allTextContents()).includes("one.glb"));
  }));

test("dropped files are one scene, packed with its side files; its warnings can be read and dismissed", { timeout: 600000 }, () =>
  withUploads(async (v, page) => {
    const buffer = `${"a long name of a buffer ".repeat(5)}größe.bin`;
    assert.ok(await drop(page, [{ name: "desk.gltf", words: gltf(buffer) }, { name: buffer, bytes: triangle(1) }]));
    await shows(page, "desk.gltf");
    await v.settled();
    assert.match(await text(page, "#notices"), /1 warning about desk\.gltf.*gone\.png/s);
    await v.screenshot("notice");
    await page.click("#notices button");
    assert.ok(!await page.isVisible("#notices"));
  }));

test("several scenes are uploaded one after the other; what fails is named; a map lights the scene", { timeout: 600000 }, () =>
  withUploads(async (v, page) => {
    const scene = (x) => [...glb(x)];
    await drop(page, [{ name: "one.glb", bytes: scene(1) }, { name: "torn.glb", bytes: scene(1).slice(0, 90) }, { name: "two.glb", bytes: scene(2) },
                      { name: "torn.hdr", words: "#?RADIANCE" }, { name: "evening.hdr", bytes: [...hdr([200, 100, 50, 128])] }]);
    await page.waitForSelector("#notices [data-kind=uploads]");
    await shows(page, "two.glb");
    const titles = await page.locator("#scene option").allTextContents();
    assert.ok(titles.includes("one.glb") && titles.includes("two.glb") && !titles.includes("torn.glb"), `${titles}`);
    assert.match(await text(page, "#notices"), /2 of 5 could not be opened.*torn\.glb: .*differs from that in its header.*torn\.hdr: /s);
    const { environment } = await v.settled();
    assert.match(environment.map, /^upload-/);
    assert.equal(await page.locator("#light select").evaluate((s) => s.selectedOptions[0].textContent), "evening.hdr");
  }));

test("a selected folder is one scene with its relative paths", { timeout: 600000 }, () =>
  withUploads(async (v, page) => {
    const folder = join(mkdtempSync(join(tmpdir(), "clerestory-folder-")), "town");
    mkdirSync(join(folder, "parts"), { recursive: true });
    writeFileSync(join(folder, "model.gltf"), gltf("parts/mesh.bin"));
    writeFileSync(join(folder, "parts", "mesh.bin"), Buffer.from(triangle(1)));
    await page.setInputFiles("#upload-folder", folder);
    await shows(page, "town");
    assert.match((await v.settled()).scene, /^upload-/);
  }));

visit("a server without uploads says so, and files without a scene are named", {}, async (v, page) => {
  await drop(page, [{ name: "one.glb", bytes: [1] }]);
  await page.waitForSelector("#note.bad");
  assert.match(await text(page, "#note"), /does not accept files.*--uploads/s);
});
