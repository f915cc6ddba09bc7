#!/usr/bin/env python3
"""Reads what examples/labels.py wrote, from the published formats alone, and compares it with the geometry of six-walls.

    read_labels.py FOLDER

COCO: https://cocodataset.org/#format-data. BOP: bop_datasets_format.md of the BOP toolkit. Shares no code with the example.
"""
import json
import math
import os
import sys
import zlib

folder = sys.argv[1]
RADIUS = 500.0  # of the ball of six-walls, in its middle, millimetres


def load(*path):
    return json.load(open(os.path.join(folder, *path)))


def decoded(*path):
    """Rows of a grey PNG without a row filter."""
    data = open(os.path.join(folder, *path), "rb").read()
    assert data[:8] == bytes([137, 80, 78, 71, 13, 10, 26, 10])
    at, body, size = 8, b"", None
    while at < len(data):
        length, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        content = data[at + 8:at + 8 + length]
        assert int.from_bytes(data[at + 8 + length:at + 12 + length], "big") == zlib.crc32(kind + content)
        if kind == b"IHDR":
            size = int.from_bytes(content[:4], "big"), int.from_bytes(content[4:8], "big"), content[8]
            assert content[9] == 0, "grey"
        if kind == b"IDAT":
            body += content
        at += 12 + length
    width, height, bits = size
    raw, step = zlib.decompress(body), bits // 8
    rows = []
    for y in range(height):
        line = raw[y * (1 + width * step):(y + 1) * (1 + width * step)]
        assert line[0] == 0
        rows.append([int.from_bytes(line[1 + x * step:1 + (x + 1) * step], "big") for x in range(width)])
    return rows


def pixels_of(segmentation):
    """Pixels (x, y) of uncompressed run lengths: columns first, zeros first."""
    height, width = segmentation["size"]
    flat = [bit for i, run in enumerate(segmentation["counts"]) for bit in [i % 2] * run]
    assert len(flat) == width * height
    return {(i // height, i % height) for i, bit in enumerate(flat) if bit}


def bounds(pixels):
    xs, ys = [x for x, _ in pixels], [y for _, y in pixels]
    return [min(xs), min(ys), max(xs) - min(xs) + 1, max(ys) - min(ys) + 1]


# ---- COCO -----------------------------------------------------------------------------------------
coco = load("coco.json")
images = {image["id"]: image for image in coco["images"]}
names = {category["id"]: category["name"] for category in coco["categories"]}
assert sorted(names.values()) == ["ball", "wall"], names
assert len({a["id"] for a in coco["annotations"]}) == len(coco["annotations"])
shown = {}  # by image: sets of pixels
for a in coco["annotations"]:
    pixels = pixels_of(a["segmentation"])
    assert a["iscrowd"] == 0 and a["area"] == len(pixels) > 0 and a["bbox"] == bounds(pixels), a["id"]
    image = images[a["image_id"]]
    assert a["segmentation"]["size"] == [image["height"], image["width"]]
    assert os.path.getsize(os.path.join(folder, "images", image["file_name"])) > 0
    shown.setdefault(a["image_id"], []).append((names[a["category_id"]], pixels))
for parts in shown.values():  # the room is closed: every pixel belongs to one instance
    assert sum(len(p) for _, p in parts) == len(set().union(*(p for _, p in parts))) == 96 * 64

# ---- BOP ------------------------------------------------------------------------------------------
scene = ("bop", "000001")
cameras, poses, infos = (load(*scene, name + ".json") for name in ("scene_camera", "scene_gt", "scene_gt_info"))
assert set(cameras) == set(poses) == set(infos) == {str(i) for i in images}
for key, camera in cameras.items():
    fx, _, cx, _, fy, cy, _, _, last = camera["cam_K"]
    assert last == 1
    depth = decoded(*scene, "depth", f"{int(key):06}.png")
    balls = 0
    for number, (pose, info) in enumerate(zip(poses[key], infos[key])):
        mask = decoded(*scene, "mask_visib", f"{int(key):06}_{number:06}.png")
        pixels = {(x, y) for y, row in enumerate(mask) for x, value in enumerate(row) if value == 255}
        assert info["px_count_visib"] == len(pixels) <= info["px_count_all"]
        assert abs(info["visib_fract"] * info["px_count_all"] - len(pixels)) < 1e-6
        assert info["bbox_visib"] == (bounds(pixels) if pixels else [-1, -1, -1, -1])
        x, y, w, h = info["bbox_obj"]
        assert all(x <= i < x + w and y <= j < y + h for i, j in pixels)
        if pixels:
            assert pixels in [p for _, p in shown[int(key)]]
        r = pose["cam_R_m2c"]
        assert abs(sum(r[i] * r[i] for i in range(9)) - 3) < 1e-6
        if ("ball", pixels) not in shown[int(key)]:
            continue
        balls += 1
        # The model's origin is the middle of the ball: its depth there is a radius less.
        tx, ty, tz = pose["cam_t_m2c"]
        u, v = fx * tx / tz + cx, fy * ty / tz + cy
        found = depth[round(v)][round(u)] * camera["depth_scale"]
        assert abs(found - (tz - RADIUS)) < 25, (found, tz)
        assert abs(w - h) <= 2, "the ball is seen whole, by nothing hidden"
        assert abs(x + w / 2 - 0.5 - u) < 1.5 and abs(y + h / 2 - 0.5 - v) < 1.5
        # Its silhouette is wider than its diameter over the distance: r f / sqrt(d^2 - r^2).
        distance = math.sqrt(tx * tx + ty * ty + tz * tz)
        assert abs(w / 2 - RADIUS * fx / math.sqrt(distance ** 2 - RADIUS ** 2)) < 1.5
    assert balls == 1
print(f"{len(images)} frames: {len(coco['annotations'])} annotations of COCO and {sum(map(len, poses.values()))} poses of BOP are right")
