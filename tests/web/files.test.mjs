// Files that become scenes: grouping, archives, names of saved pictures; lights, warnings and the turntable.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";

import { bytesOf, contentOf, filesOf, uploadsOf } from "../../web/files.js";
import { commonValue, lightGroups, lightRange, ownValue } from "../../web/light_rows.js";
import { warningLines } from "../../web/notices.js";
import { fileName } from "../../web/picture.js";
import { headerOf, pathRecord, tarOf } from "../../web/tar.js";
import { Rotation, turned } from "../../web/turntable.js";
import { near } from "./near.mjs";

const file = (path, text = path) => ({ path, file: new Blob([text]) });

// ---- archives -----------------------------------------------------------------------------------

test("tar reads the archive: long, foreign and plain names, empty files and whole blocks", async () => {
  const long = `${"folder with a long name/".repeat(9)}model.bin`;
  const files = [file("a.gltf", "{}"), file(long, "long"), file("grün/日本.png", "foreign"), file("empty", ""), file("block", "x".repeat(512)),
                 file(`${"n".repeat(100)}`, "limit"), file(`${"n".repeat(101)}`, "over")];
  const folder = mkdtempSync(join(tmpdir(), "clerestory-tar-"));
  writeFileSync(join(folder, "all.tar"), Buffer.from(await tarOf(files).arrayBuffer()));
  execFileSync("tar", ["-xf", "all.tar"], { cwd: folder, env: { ...process.env, LC_ALL: "C.UTF-8" } });
  for (const { path, file: content } of files) assert.equal(readFileSync(join(folder, path), "utf8"), await content.text(), path);
});

test("the order of the files does not change the archive", async () => {
  const files = [file("b"), file("a"), file("c/d")];
  const bytes = async (list) => Buffer.from(await tarOf(list).arrayBuffer());
  assert.deepEqual(await bytes(files), await bytes([...files].reverse()));
  assert.equal((await bytes(files)).length, 3 * 1024 + 1024);
});

test("a record states its own length, also where that gets another digit", () => {
  for (let length = 1; length < 1100; ++length) {
    const record = pathRecord("p".repeat(length));
    assert.equal(parseInt(new TextDecoder().decode(record), 10), record.length);
  }
  const header = headerOf("x", 5);
  const stored = parseInt(new TextDecoder().decode(header.subarray(148, 154)), 8);
  header.fill(0x20, 148, 156);
  assert.equal(header.reduce((sum, byte) => sum + byte, 0), stored);
});

// ---- grouping -----------------------------------------------------------------------------------

const namesOf = ({ uploads, maps, others }) => [uploads.map((u) => [u.name, ...u.files.map((f) => f.path)]), maps.map((m) => m.name), others];

test("one file is sent as it is; an OBJ alone and a scene of several files are archives", () => {
  const [one] = uploadsOf([file("duck.glb")]).uploads;
  assert.equal(contentOf(one), one.files[0].file);
  assert.equal(contentOf(uploadsOf([file("duck.obj")]).uploads[0]).type, "application/x-tar");
  const { uploads } = uploadsOf([file("duck.gltf"), file("duck.bin"), file("duck.png")]);
  assert.equal(uploads.length, 1);
  assert.equal(contentOf(uploads[0]).type, "application/x-tar");
  assert.equal(bytesOf(uploads[0]), 25);
});

test("scenes without side files are uploaded separately; side files go along with each scene", () => {
  assert.deepEqual(namesOf(uploadsOf([file("a.glb"), file("b.stl"), file("c.zip")])),
                   [[["c.zip", "c.zip"], ["a.glb", "a.glb"], ["b.stl", "b.stl"]], [], []]);
  assert.deepEqual(namesOf(uploadsOf([file("a.gltf"), file("b.gltf"), file("wood.png")])),
                   [[["a.gltf", "a.gltf", "wood.png"], ["b.gltf", "b.gltf", "wood.png"]], [], []]);
});

test("a folder is one scene with relative paths; files of the system and maps are left out", () => {
  const files = ["town/town.gltf", "town/textures/wall.png", "town/.DS_Store", "__MACOSX/x.glb", "town/sky.hdr", "loose.glb"].map((p) => file(p));
  assert.deepEqual(namesOf(uploadsOf(files)), [[["town", "town/town.gltf", "town/textures/wall.png"], ["loose.glb", "loose.glb"]], ["sky.hdr"], []]);
});

test("maps and files of other kinds alone are no scene", () => {
  assert.deepEqual(namesOf(uploadsOf([file("sky.exr"), file("cube.ktx2"), file("notes.txt")])), [[], ["sky.exr", "cube.ktx2"], ["notes.txt"]]);
  assert.deepEqual(namesOf(uploadsOf([file("a.gltf"), file("wall.ktx2")])), [[["a.gltf", "a.gltf", "wall.ktx2"]], [], []]);
  assert.deepEqual(namesOf(uploadsOf([])), [[], [], []]);
});

test("folders are read completely, although the browser lists them in parts", async () => {
  const entryOf = (fullPath, children) => (children
    ? { isFile: false, createReader: () => { const left = [...children]; return { readEntries: (done) => done(left.splice(0, 2)) }; } }
    : { isFile: true, fullPath, file: (done) => done(new Blob([fullPath])) });
  const inner = ["a", "b", "c", "d", "e"].map((n) => entryOf(`/top/${n}.png`));
  const found = await filesOf([entryOf("/top", [...inner, entryOf("/top/deep", [entryOf("/top/deep/x.bin")])]), entryOf("/y.glb")]);
  assert.deepEqual(found.map((f) => f.path), ["top/a.png", "top/b.png", "top/c.png", "top/d.png", "top/e.png", "top/deep/x.bin", "y.glb"]);
});

// ---- lights -------------------------------------------------------------------------------------

const sun = { name: "sun", kind: "directional", intensity: [2, 1, 0.5] }, lamp = { name: "lamp", kind: "point", intensity: [0, 0, 0], radius: 0.1 };

test("lights of one name are one row; all lights have a row if names do not reach them", () => {
  const rows = (list) => lightGroups(list).map(({ name, lights }) => [name, lights.length]);
  assert.deepEqual(rows([]), []);
  assert.deepEqual(rows([sun]), [["sun", 1]]);
  assert.deepEqual(rows([lamp, lamp]), [["lamp", 2]]);
  assert.deepEqual(rows([sun, lamp, lamp]), [[undefined, 3], ["sun", 1], ["lamp", 2]]);
  assert.deepEqual(rows([{ ...sun, name: "" }]), [[undefined, 1]]);
});

test("controls of lights begin at the values of the scene", () => {
  assert.deepEqual(["enabled", "intensity", "color", "radius"].map((f) => ownValue(sun, f)), [true, 2, [1, 0.5, 0.25], 0]);
  assert.deepEqual(["intensity", "color", "radius"].map((f) => ownValue(lamp, f)), [0, undefined, 0.1]);
  assert.deepEqual(["enabled", "intensity", "radius"].map((f) => commonValue([sun, lamp], f)), [true, undefined, undefined]);
  assert.deepEqual(["intensity", "radius"].map((f) => commonValue([sun, { ...sun, name: "moon" }], f)), [2, 0]);
  assert.deepEqual(lightRange("intensity", [sun], 10), [0, 8]);
  assert.deepEqual([lightRange("radius", [sun], 10), lightRange("radius", [lamp], 10)], [[0, 0.1], [0, 0.5]]);
});

// ---- texts and motion -----------------------------------------------------------------------------

test("a warning says what it is about, once, and how often", () => {
  assert.deepEqual(warningLines([{ subject: "wood", message: "the texture is missing", count: 2 }, { subject: "wood", message: "wood is grey", count: 1 },
                                 { subject: "", message: "odd", count: 1 }]), ["wood: the texture is missing (2 times)", "wood is grey", "odd"]);
  assert.deepEqual(warningLines(undefined), []);
});

test("a saved picture is named by scene and size, without characters that files cannot have", () => {
  const size = { width: 64, height: 36 };
  assert.equal(fileName("Brass lamp.glb", size, "png"), "Brass lamp 64x36.png");
  assert.equal(fileName("../a/b:c", size, "jpeg"), "a-b-c 64x36.jpg");
  assert.equal(fileName("???", size, "webp"), "frame 64x36.webp");
});

test("the turntable turns at constant speed, pauses on input, and does not jump afterwards", () => {
  const rotation = new Rotation();
  assert.equal(rotation.step(10), 0);
  near([rotation.step(10.5), rotation.step(11)], [0.5, 0.5]);
  rotation.input(11.1);
  assert.equal(rotation.step(12), 0);
  assert.equal(rotation.step(13), 0);
  near([rotation.step(13.5)], [0.5]);
  const camera = { target: [1, 2, 3], distance: 4, yaw: 0.2, pitch: 0.1, yfov: 0.9 };
  let now = camera;
  for (let i = 0; i < 160; ++i) now = turned(now, 0.1);
  near([Math.cos(now.yaw), now.pitch, now.distance], [Math.cos(camera.yaw), 0.1, 4], 1e-9);
});
