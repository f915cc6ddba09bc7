// Packs files into an uncompressed tar archive (POSIX.1-2001, "pax"). Pure. The same files give the same bytes: the header
// has no times and no owners.
//
//   tarOf([{ path: "town/town.gltf", file }, { path: "town/town.bin", file: other }])  // -> Blob

const kBlock = 512;
const kPlainName = /^[\x20-\x7e]{1,100}$/;  // other names are in a record before the header
const kFile = "0", kRecords = "x";
const encoder = new TextEncoder();

// The 512 bytes before the content of a file of `size` bytes.
export function headerOf(name, size, type = kFile) {
  const header = new Uint8Array(kBlock);
  const put = (at, text) => header.set(encoder.encode(text), at);
  const octal = (value, digits) => value.toString(8).padStart(digits, "0");
  put(0, name);
  put(100, `${octal(0o644, 7)}\0${octal(0, 7)}\0${octal(0, 7)}\0${octal(size, 11)}\0${octal(0, 11)}\0`);
  put(148, " ".repeat(8));  // the checksum counts as spaces
  put(156, type);
  put(257, "ustar\x0000");
  const sum = header.reduce((total, byte) => total + byte, 0);
  put(148, `${octal(sum, 6)}\0 `);
  return header;
}

// "LENGTH path=NAME\n", where LENGTH includes its own digits.
export function pathRecord(path) {
  const rest = encoder.encode(` path=${path}\n`).length;
  let length = rest + 1;
  while (String(length).length + rest !== length) length = String(length).length + rest;
  return encoder.encode(`${length} path=${path}\n`);
}

const padding = (size) => new Uint8Array((kBlock - (size % kBlock)) % kBlock);

// files: [{ path, file }], paths relative with "/"; file: a Blob. Sorted by path.
export function tarOf(files) {
  const parts = [];
  for (const { path, file } of [...files].sort((a, b) => (a.path < b.path ? -1 : 1))) {
    if (!kPlainName.test(path)) {
      const record = pathRecord(path);
      parts.push(headerOf("path", record.length, kRecords), record, padding(record.length));
    }
    const name = kPlainName.test(path) ? path : "file";
    parts.push(headerOf(name, file.size), file, padding(file.size));
  }
  parts.push(new Uint8Array(2 * kBlock));
  return new Blob(parts, { type: "application/x-tar" });
}
