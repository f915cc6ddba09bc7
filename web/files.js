// From dropped or selected files to uploads. Pure, except that filesOf() reads folders.
import { grouped } from "./lists.js";
import { tarOf } from "./tar.js";

const kScenes = ["glb", "gltf", "obj", "fbx", "dae", "ply", "stl", "3ds"];
const kArchives = ["zip", "tar", "tgz", "gz"];
const kMaps = ["hdr", "exr", "ktx", "dds"];  // environment maps only; .ktx2 may be a texture
const kAlone = "obj";                        // has no mark by which the server recognises it outside an archive

const extensionOf = (path) => /\.([^./]+)$/.exec(path)?.[1].toLowerCase() ?? "";
const nameOf = (path) => path.slice(path.lastIndexOf("/") + 1);
const isScene = ({ path }) => kScenes.includes(extensionOf(path));
const isArchive = ({ path }) => kArchives.includes(extensionOf(path));
const isMap = ({ path }) => kMaps.includes(extensionOf(path));
const isOfSystem = ({ path }) => path.split("/").some((part) => part.startsWith(".") || part === "__MACOSX" || part === "Thumbs.db");

export const kSupported = `Scenes: ${kScenes.map((e) => `.${e}`).join(" ")}, or a folder or archive (.zip .tar .tgz) of one with its files. Environment maps: .hdr .exr .ktx .ktx2 .dds.`;

// Sorts files into scenes. files: [{ path, file }]; a path with "/" is in a dropped folder.
// -> { uploads: [{ name, files }], maps: [{ name, file }], others: [name] }: what becomes a scene each; environment maps; and
// files that belong to no scene.
//
// A folder is one scene. Of loose files, each archive and each scene file is a scene; files of other kinds go along with every one.
export function uploadsOf(files) {
  const usable = files.filter((f) => !isOfSystem(f));
  const folders = grouped(usable, ({ path }) => (path.includes("/") ? path.slice(0, path.indexOf("/")) : ""));
  const uploads = [], others = [];
  const maps = usable.filter(isMap);
  for (const [folder, all] of folders) {
    const members = all.filter((f) => !isMap(f));
    const scenes = members.filter(isScene), archives = members.filter(isArchive);
    if (folder) {
      if (scenes.length) uploads.push({ name: folder, files: members });
      else if (archives.length) uploads.push(...archives.map(alone));
      else others.push(...members);
      continue;
    }
    const sides = members.filter((f) => !isScene(f) && !isArchive(f));
    uploads.push(...archives.map(alone), ...scenes.map((scene) => ({ name: nameOf(scene.path), files: [scene, ...sides] })));
    if (!scenes.length) others.push(...sides);
  }
  const isLooseMap = ({ path }) => extensionOf(path) === "ktx2" && uploads.length === 0;
  return {
    uploads,
    maps: [...maps, ...others.filter(isLooseMap)].map(({ path, file }) => ({ name: nameOf(path), file })),
    others: others.filter((f) => !isLooseMap(f)).map(({ path }) => nameOf(path)),
  };
}
const alone = (file) => ({ name: nameOf(file.path), files: [file] });

// What is sent: the file itself, or an archive of several.
export function contentOf({ files }) {
  const [first] = files;
  return files.length === 1 && extensionOf(first.path) !== kAlone ? first.file : tarOf(files);
}

export const bytesOf = ({ files }) => files.reduce((sum, { file }) => sum + file.size, 0);

// ---- drops and choices ------------------------------------------------------------------------

const fileOf = (entry) => new Promise((resolve, reject) => entry.file(resolve, reject));
const batchOf = (reader) => new Promise((resolve, reject) => reader.readEntries(resolve, reject));

// The files below entries (FileSystemEntry), with paths that begin with the name of the dropped folder.
export async function filesOf(entries) {
  const found = [];
  for (const entry of entries) {
    if (entry.isFile) found.push({ path: entry.fullPath.replace(/^\//, ""), file: await fileOf(entry) });
    else {
      const reader = entry.createReader();  // returns its entries in batches; an empty one is the end
      for (let batch = await batchOf(reader); batch.length; batch = await batchOf(reader)) found.push(...await filesOf(batch));
    }
  }
  return found;
}

// The files of <input type=file>.
export const selectedFiles = (list) => [...list].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
