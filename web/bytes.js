// Reading answers that are no JSON: parts of a multipart/mixed body, and NumPy files. Pure.

const text = new TextDecoder();

function indexOf(bytes, pattern, from) {
  for (let i = from; i + pattern.length <= bytes.length; ++i) {
    let k = 0;
    while (k < pattern.length && bytes[i + k] === pattern.charCodeAt(k)) ++k;
    if (k === pattern.length) return i;
  }
  return -1;
}

// -> [{ headers: { "content-type": … }, bytes }]. Every part must tell its Content-Length.
export function partsOf(contentType, bytes) {
  const boundary = /boundary="?([^";]+)"?/.exec(contentType)?.[1];
  if (!boundary) throw new Error(`no boundary in ${contentType}`);
  const parts = [];
  for (let at = 0; ;) {
    at = indexOf(bytes, `--${boundary}`, at);
    if (at < 0) break;
    const head = at + boundary.length + 4;
    const end = indexOf(bytes, "\r\n\r\n", head);
    if (end < 0) break;
    const headers = Object.fromEntries(text.decode(bytes.subarray(head, end)).split("\r\n").map((line) => {
      const colon = line.indexOf(":");
      return [line.slice(0, colon).toLowerCase(), line.slice(colon + 1).trim()];
    }));
    const length = Number(headers["content-length"]);
    if (!Number.isInteger(length)) throw new Error("a part without Content-Length");
    parts.push({ headers, bytes: bytes.subarray(end + 4, end + 4 + length) });
    at = end + 4 + length;
  }
  return parts;
}

// The numbers of a little-endian float32 NPY file of version 1, in its own order.
export function floatsOf(buffer) {
  const view = new DataView(buffer);
  if (view.getUint8(0) !== 0x93 || text.decode(buffer.slice(1, 6)) !== "NUMPY") throw new Error("not an NPY file");
  const start = 10 + view.getUint16(8, true);
  if (!text.decode(buffer.slice(10, start)).includes("'<f4'")) throw new Error("not float32");
  return Array.from({ length: (buffer.byteLength - start) / 4 }, (_, i) => view.getFloat32(start + 4 * i, true));
}
