#!/usr/bin/env python3
"""Turns a sequence into labels in the formats of COCO and BOP.

    labels.py SEQUENCE.tar FOLDER

SEQUENCE.tar is the answer of POST /v1/sequences with "output": { "format": "png" } and the channels color, depth, objectId and
instances (docs/labels.md has an example). With "classes" in the output, instances of no class are left out; without, every
instance is of the class "object". Uses the standard library only. Writes FOLDER/coco.json with FOLDER/images, and the scene
FOLDER/bop/000001.
"""
import json
import pathlib
import struct
import sys
import tarfile
import zlib


def floats_of(npy):
    """Width, height and numbers of a file with one float32 for each pixel."""
    start = 10 + struct.unpack_from("<H", npy, 8)[0]
    header = npy[10:start].decode()
    height, width = (int(n) for n in header.split("(")[1].split(")")[0].split(",")[:2])
    return width, height, struct.unpack_from(f"<{width * height}f", npy, start)


def png_of(width, height, bits, samples):
    """A grey picture of 8 or 16 bits."""
    row, code = width * bits // 8, ">%d" + ("B" if bits == 8 else "H")
    data = struct.pack(code.replace("%d", str(width * height)), *samples)
    rows = b"".join(b"\0" + data[i * row:(i + 1) * row] for i in range(height))

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    head = struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def run_lengths(mask, width, height):
    """COCO's: column by column, the numbers of zeros and ones in turn."""
    counts, value, length = [], False, 0
    for x in range(width):
        for y in range(height):
            if mask[y * width + x] != value:
                counts.append(length)
                value, length = not value, 0
            length += 1
    return {"counts": counts + [length], "size": [height, width]}


def box_of(box):
    return [box[side] for side in ("x", "y", "width", "height")] if box else [-1, -1, -1, -1]


# ---- matrices, as lists of rows -------------------------------------------------------------------

def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def rows_of(column_major):
    return [list(column_major[i::4]) for i in range(4)]


def inverse_of(rigid):
    turned = [[rigid[j][i] for j in range(3)] for i in range(3)]
    moved = [-sum(turned[i][k] * rigid[k][3] for k in range(3)) for i in range(3)]
    return [turned[i] + [moved[i]] for i in range(3)] + [[0, 0, 0, 1]]


def opencv_from_world(camera):
    """OpenCV's camera looks along +Z with Y down; that of the server along -Z with Y up."""
    flip = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]
    return product(flip, inverse_of(rows_of(camera["cameraToWorld"])))


def rotation_and_millimetres(matrix):
    """Row by row. Without the scale of the columns."""
    scales = [sum(matrix[i][j] ** 2 for i in range(3)) ** 0.5 for j in range(3)]
    rotation = [matrix[i][j] / scales[j] for i in range(3) for j in range(3)]
    return rotation, [1000 * matrix[i][3] for i in range(3)]


# ---- one frame ------------------------------------------------------------------------------------

class Frame:
    def __init__(self, files, stem):
        self.index = int(stem)
        self.stem = stem
        self.picture = files[stem + ".png"]
        self.camera = json.loads(files[stem + ".json"])["camera"]
        found = json.loads(files[stem + ".instances.json"])
        self.categories = found["classes"] or ["object"]
        self.instances = [i for i in found["instances"] if i["classId"] > 0 or not found["classes"]]
        self.width, self.height, ids = floats_of(files[stem + ".objectId.npy"])
        self.ids = [int(i) for i in ids]
        self.depth = floats_of(files[stem + ".depth.npy"])[2]

    def mask(self, instance):
        return [i == instance["objectId"] for i in self.ids]


def add_to_coco(coco, frame):
    name = frame.stem + ".png"
    coco["images"].append({"id": frame.index, "file_name": name, "width": frame.width, "height": frame.height})
    for instance in frame.instances:
        if instance["pixels"] == 0:
            continue
        coco["annotations"].append({
            "id": len(coco["annotations"]) + 1, "image_id": frame.index, "category_id": instance["classId"] or 1,
            "iscrowd": 0, "area": instance["pixels"], "bbox": box_of(instance["box"]),
            "segmentation": run_lengths(frame.mask(instance), frame.width, frame.height)})


def add_to_bop(files, frame):
    """`files`: the three JSON files, by name. Returns the pictures of the frame, by path."""
    key, lens = str(frame.index), frame.camera["intrinsics"]
    camera_from_world = opencv_from_world(frame.camera)
    rotation, moved = rotation_and_millimetres(camera_from_world)
    step = max(max(frame.depth) * 1000 / 65535, 1e-6)
    files["scene_camera"][key] = {
        # The first pixel is centred at 0, 0 there and at 0.5, 0.5 here.
        "cam_K": [lens["fx"], 0, lens["cx"] - 0.5, 0, lens["fy"], lens["cy"] - 0.5, 0, 0, 1],
        "cam_R_w2c": rotation, "cam_t_w2c": moved, "depth_scale": step}
    pictures = {f"rgb/{frame.stem}.png": frame.picture,
                f"depth/{frame.stem}.png": png_of(frame.width, frame.height, 16,
                                                  [round(d * 1000 / step) for d in frame.depth])}
    poses, infos = files["scene_gt"].setdefault(key, []), files["scene_gt_info"].setdefault(key, [])
    for number, instance in enumerate(frame.instances):
        matrix = product(camera_from_world, rows_of(instance["worldFromModel"]))
        rotation, moved = rotation_and_millimetres(matrix)
        poses.append({"cam_R_m2c": rotation, "cam_t_m2c": moved, "obj_id": instance["objectId"]})
        infos.append({"bbox_obj": box_of(instance["amodalBox"]), "bbox_visib": box_of(instance["box"]),
                      "px_count_all": instance["amodalPixels"], "px_count_valid": instance["amodalPixels"],
                      "px_count_visib": instance["pixels"], "visib_fract": instance["visibleShare"]})
        mask = png_of(frame.width, frame.height, 8, [255 * m for m in frame.mask(instance)])
        pictures[f"mask_visib/{frame.stem}_{number:06}.png"] = mask
    return pictures


def write(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content if isinstance(content, bytes) else json.dumps(content).encode())


def main(tar, folder):
    with tarfile.open(tar) as archive:
        files = {member.name: archive.extractfile(member).read() for member in archive}
    stems = sorted(name[:6] for name in files if name.endswith(".instances.json"))
    if not stems:
        raise SystemExit("the sequence has no channel instances")
    coco = {"images": [], "annotations": [], "categories": []}
    bop = {"scene_camera": {}, "scene_gt": {}, "scene_gt_info": {}}
    for stem in stems:
        frame = Frame(files, stem)
        coco["categories"] = [{"id": i + 1, "name": name} for i, name in enumerate(frame.categories)]
        add_to_coco(coco, frame)
        write(folder / "images" / (stem + ".png"), frame.picture)
        for path, picture in add_to_bop(bop, frame).items():
            write(folder / "bop" / "000001" / path, picture)
    write(folder / "coco.json", coco)
    for name, content in bop.items():
        write(folder / "bop" / "000001" / (name + ".json"), content)
    print(f"{len(stems)} frames, {len(coco['annotations'])} instances of COCO, "
          f"{sum(len(p) for p in bop['scene_gt'].values())} poses of BOP in {folder}")


if __name__ == "__main__":
    main(sys.argv[1], pathlib.Path(sys.argv[2]))
