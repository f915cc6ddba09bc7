#!/usr/bin/env python3
"""A ring of views round a scene, each with its depth and its camera: what a team that makes training images needs.

    orbit.py [SERVER] [SCENE] [FOLDER] [VIEWS]

Only the standard library. Writes 000.jpg, 000.npy (float32 metres along the view) and cameras.json, whose
cameraToWorld are the matrices that were sent: OpenCV axes (x right, y down, z ahead), row by row.
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


def ask(path, body=None):
    """Bytes of an answer; waits as long as the server says while it loads or is busy."""
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
    raise SystemExit("the server stayed busy")


def camera_to_world(eye, target):
    """OpenCV: x right, y down, z ahead; +Y is up in the world. Rows of the matrix."""
    ahead = normalised([t - e for e, t in zip(eye, target)])
    right = normalised(cross(ahead, [0.0, 1.0, 0.0]))
    down = cross(ahead, right)
    return [[right[i], down[i], ahead[i], eye[i]] for i in range(3)] + [[0.0, 0.0, 0.0, 1.0]]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def normalised(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def floats_of(npy):
    """The numbers of a version 1.0 NPY file of little-endian float32."""
    assert npy[:6] == b"\x93NUMPY" and b"'<f4'" in npy[:128]
    start = 10 + struct.unpack_from("<H", npy, 8)[0]
    return struct.unpack(f"<{(len(npy) - start) // 4}f", npy[start:])


ask("/v1/frames", {"scene": scene, "width": 8, "height": 8})  # a scene loads when it is first asked for
about = json.loads(ask(f"/v1/scenes/{scene}"))
eye, target = about["defaultView"]["position"], about["defaultView"]["target"]
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
    (folder / f"{i:03}.jpg").write_bytes(ask("/v1/frames", frame))
    depth = ask("/v1/frames", {**frame, "output": {"format": "npy", "channel": "depth"}})
    (folder / f"{i:03}.npy").write_bytes(depth)
    metres = [d for d in floats_of(depth) if d > 0]  # 0 where nothing is
    cameras.append({"file": f"{i:03}.jpg", "cameraToWorld": matrix, "nearest": min(metres, default=None)})
(folder / "cameras.json").write_text(json.dumps({"focal": FOCAL, "size": [WIDTH, HEIGHT], "frames": cameras}, indent=1))
print(f"{folder}: {views} views of {scene}")
