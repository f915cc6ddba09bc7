#!/usr/bin/env python3
"""Renders a ring of views around a scene, each with depth and camera, for example as training images.

    orbit.py [SERVER] [SCENE] [FOLDER] [VIEWS]

Uses the standard library only. Writes 000.jpg, 000.npy (float32 metres along the viewing direction) and cameras.json, whose
cameraToWorld are the matrices that were sent: OpenCV axes (x right, y down, z forward), row by row.
"""
import json
import math
import pathlib
import struct
import sys
import time
import urllib.error
import urllib.request

server = sys.argv[1] if len(sys.argv) > 1 else "http://localhost:8080"
scene = sys.argv[2] if len(sys.argv) > 2 else "teapots"
folder = pathlib.Path(sys.argv[3] if len(sys.argv) > 3 else "orbit")
views = int(sys.argv[4]) if len(sys.argv) > 4 else 12
WIDTH, HEIGHT, FOCAL = 320, 240, 300.0


def send(path, body=None):
    """Returns the bytes of an answer; retries as the server says while it loads or is busy."""
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(server + path, data, {"Content-Type": "application/json"})
    for _ in range(120):
        try:
            with urllib.request.urlopen(request) as answer:
                return answer.read()
        except urllib.error.HTTPError as error:
            if error.code not in (409, 429, 503):
                raise SystemExit(error.read().decode())
            time.sleep(float(error.headers.get("Retry-After", 1)))
    raise SystemExit("the server is still busy; giving up")


def camera_to_world(eye, target):
    """Rows of a matrix with OpenCV axes: x right, y down, z forward. +Y is up in the world."""
    forward = normalized([t - e for e, t in zip(eye, target)])
    right = normalized(cross(forward, [0.0, 1.0, 0.0]))
    down = cross(forward, right)
    return [[right[i], down[i], forward[i], eye[i]] for i in range(3)] + [[0.0, 0.0, 0.0, 1.0]]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def normalized(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def parse_npy(npy):
    """The values of an NPY file, version 1.0, of little-endian float32."""
    assert npy[:6] == b"\x93NUMPY" and b"'<f4'" in npy[:128]
    start = 10 + struct.unpack_from("<H", npy, 8)[0]
    return struct.unpack(f"<{(len(npy) - start) // 4}f", npy[start:])


send("/v1/frames", {"scene": scene, "width": 8, "height": 8})  # a scene loads on first use
description = json.loads(send(f"/v1/scenes/{scene}"))
eye, target = description["defaultView"]["position"], description["defaultView"]["target"]
reach, height = math.dist(eye[::2], target[::2]), eye[1]
folder.mkdir(parents=True, exist_ok=True)

cameras = []
for i in range(views):
    angle = 2 * math.pi * i / views
    matrix = camera_to_world([target[0] + reach * math.sin(angle), height, target[2] + reach * math.cos(angle)], target)
    frame = {
        "scene": scene, "width": WIDTH, "height": HEIGHT,
        "camera": {
            "cameraToWorld": [matrix[row][column] for column in range(4) for row in range(4)],  # column by column
            "convention": "opencv",
            "intrinsics": {"fx": FOCAL, "fy": FOCAL, "cx": WIDTH / 2, "cy": HEIGHT / 2, "pixelCenter": "half"},
        },
    }
    (folder / f"{i:03}.jpg").write_bytes(send("/v1/frames", frame))
    depth = send("/v1/frames", {**frame, "output": {"format": "npy", "channel": "depth"}})
    (folder / f"{i:03}.npy").write_bytes(depth)
    metres = [d for d in parse_npy(depth) if d > 0]  # 0 is the background
    cameras.append({"file": f"{i:03}.jpg", "cameraToWorld": matrix, "nearest": min(metres, default=None)})
(folder / "cameras.json").write_text(json.dumps({"focal": FOCAL, "size": [WIDTH, HEIGHT], "frames": cameras}, indent=1))
print(f"{folder}: {views} views of {scene}")
