#!/usr/bin/env python3
"""Unprojects depth of every lens: a frame as points in the world, from the camera that the server reports.

    lenses.py [SERVER] [SCENE]

Uses the standard library only. ray(camera, u, v) is the direction of a pixel and pixel(camera, direction) its inverse, for
the `camera` of a plan or of a sequence's files; copy them. Prints for each lens how far a pixel is from the pixel of its
own ray, and the box of the points that its depth frame shows.
"""
import ast
import json
import math
import struct
import sys
import urllib.request

# ---- the lens -------------------------------------------------------------------------------------

# Right, up and ahead of each face, in the order of the layouts grid and row: right, left, up, down, back, front.
FACES = [((0, 0, 1), (0, 1, 0), (1, 0, 0)), ((0, 0, -1), (0, 1, 0), (-1, 0, 0)),
         ((1, 0, 0), (0, 0, 1), (0, 1, 0)), ((1, 0, 0), (0, 0, -1), (0, -1, 0)),
         ((-1, 0, 0), (0, 1, 0), (0, 0, 1)), ((1, 0, 0), (0, 1, 0), (0, 0, -1))]
SHEETS = {"grid": (3, 2, [0, 1, 2, 3, 4, 5]), "row": (6, 1, [0, 1, 2, 3, 4, 5]),
          "cross": (4, 3, [None, 2, None, None, 1, 5, 0, 4, None, 3, None, None])}


def distorted(lens, x, y):
    """Brown and Conrady as in OpenCV, and the Jacobian, which is symmetric: xx, xy, yy."""
    k1, k2, k3, p1, p2 = (lens[name] for name in ("k1", "k2", "k3", "p1", "p2"))
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3))
    return (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
            radial + slope * x * x + 2 * p1 * y + 6 * p2 * x,
            slope * x * y + 2 * p1 * x + 2 * p2 * y,
            radial + slope * y * y + 6 * p1 * y + 2 * p2 * x)


def undistorted(lens, u, v):
    """Newton's method from the centre; steps that come no nearer are halved."""
    x = y = 0.0
    for _ in range(100):
        dx, dy, xx, xy, yy = distorted(lens, x, y)
        dx, dy = u - dx, v - dy
        error, determinant = math.hypot(dx, dy), xx * yy - xy * xy
        step_x, step_y = (yy * dx - xy * dy) / determinant, (xx * dy - xy * dx) / determinant
        while error > 0:
            there = distorted(lens, x + step_x, y + step_y)
            if math.hypot(u - there[0], v - there[1]) < error:
                break
            step_x, step_y = step_x / 2, step_y / 2
            if abs(step_x) + abs(step_y) < 1e-17:
                return x, y
        x, y = x + step_x, y + step_y
        if error == 0:
            break
    return x, y


def angle_out(lens, theta):
    t2 = theta * theta
    return theta * (1 + t2 * (lens["k1"] + t2 * (lens["k2"] + t2 * (lens["k3"] + t2 * lens["k4"]))))


def angle_in(lens, value):
    """Bisection: 100 halvings of the range of the image circle."""
    low, high = 0.0, lens["fov"] / 2
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if angle_out(lens, middle) < value else (low, middle)
    return (low + high) / 2


def normal(camera, u, v):
    i = camera["intrinsics"]
    return (u - i["cx"]) / i["fx"], (v - i["cy"]) / i["fy"]


def placed(camera, x, y):
    i = camera["intrinsics"]
    return i["cx"] + i["fx"] * x, i["cy"] + i["fy"] * y


def ray(camera, u, v):
    """The direction of a point of the frame (pixels from the upper left corner) in the camera's axes: x right, y up, it
    looks along -z. None outside of the picture of the lens."""
    lens, width, height = camera["lens"], camera["width"], camera["height"]
    if lens["type"] == "perspective":
        x, y = undistorted(lens, *normal(camera, u, v))
        return unit((x, -y, -1.0))
    if lens["type"] == "fisheye":
        x, y = normal(camera, u, v)
        radius = math.hypot(x, y)
        if radius > angle_out(lens, lens["fov"] / 2):
            return None
        theta = angle_in(lens, radius)
        share = math.sin(theta) / radius if radius else 0.0
        return (share * x, -share * y, -math.cos(theta))
    if lens["type"] == "equirectangular":
        longitude = (u / width - 0.5) * lens["longitude"]
        latitude = (0.5 - v / height) * lens["latitude"]
        return (math.sin(longitude) * math.cos(latitude), math.sin(latitude), -math.cos(longitude) * math.cos(latitude))
    if lens["type"] == "cube":
        columns, rows, faces = SHEETS[lens["layout"]]
        column, row = min(int(u * columns / width), columns - 1), min(int(v * rows / height), rows - 1)
        face = faces[row * columns + column]
        if face is None:
            return None
        s = 2 * (u * columns / width - column) - 1
        t = 1 - 2 * (v * rows / height - row)
        return unit(tuple(s * r + t * p + a for r, p, a in zip(*FACES[face])))
    raise ValueError("an orthographic lens has one direction: (0, 0, -1)")


def pixel(camera, direction):
    """The inverse. None for a direction that the lens does not show."""
    lens, width, height = camera["lens"], camera["width"], camera["height"]
    x, y, z = direction
    if lens["type"] == "perspective":
        return placed(camera, *distorted(lens, x / -z, -y / -z)[:2]) if z < 0 else None
    if lens["type"] == "fisheye":
        sideways = math.hypot(x, y)
        theta = math.atan2(sideways, -z)
        if theta > lens["fov"] / 2:
            return None
        radius = angle_out(lens, theta) / sideways if sideways else 0.0
        return placed(camera, radius * x, -radius * y)
    if lens["type"] == "equirectangular":
        longitude, latitude = math.atan2(x, -z), math.atan2(y, math.hypot(x, z))
        return (longitude / lens["longitude"] + 0.5) * width, (0.5 - latitude / lens["latitude"]) * height
    if lens["type"] == "cube":
        columns, rows, faces = SHEETS[lens["layout"]]
        face = max(range(6), key=lambda i: dot(FACES[i][2], direction))
        right, up, ahead = (dot(axis, direction) for axis in FACES[face])
        at = faces.index(face)
        return ((at % columns + 0.5 + 0.5 * right / ahead) * width / columns,
                (at // columns + 0.5 - 0.5 * up / ahead) * height / rows)
    raise ValueError("an orthographic lens shows a direction everywhere or nowhere")


def point(camera, u, v, depth):
    """The world position that a depth frame shows: along -z for perspective lenses, along the ray for all others."""
    x, y, z = ray(camera, u, v)
    distance = depth / -z if camera["lens"]["type"] == "perspective" else depth
    m = camera["cameraToWorld"]  # column by column
    return [m[12 + i] + distance * (m[i] * x + m[4 + i] * y + m[8 + i] * z) for i in range(3)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(v):
    length = math.sqrt(dot(v, v))
    return tuple(x / length for x in v)


# ---- the frames -----------------------------------------------------------------------------------


def post(server, path, body):
    request = urllib.request.Request(server + path, json.dumps(body).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request) as answer:
        return answer.read()


def numbers(npy):
    """Rows of a float32 NPY file of two dimensions."""
    size = struct.unpack_from("<H", npy, 8)[0]
    shape = ast.literal_eval(npy[10:10 + size].decode())["shape"]
    flat = struct.unpack_from(f"<{shape[0] * shape[1]}f", npy, 10 + size)
    return [flat[row * shape[1]:(row + 1) * shape[1]] for row in range(shape[0])]


def main():
    server = sys.argv[1] if len(sys.argv) > 1 else "http://localhost:8080"
    scene = sys.argv[2] if len(sys.argv) > 2 else "six-walls"
    lenses = [{"type": "perspective", "k1": -0.2, "k2": 0.03, "p1": 0.001}, {"type": "fisheye"},
              {"type": "fisheye", "fov": 4.5, "k1": 0.02, "k2": -0.001}, {"type": "equirectangular"},
              {"type": "cube", "layout": "cross"}]
    for lens in lenses:
        frame = {"scene": scene, "width": 128, "height": 96, "output": {"channel": "depth", "format": "npy"},
                 "camera": {"position": [1.2, 0.7, 1.6], "target": [0, 0, 0], "lens": lens}}
        camera = json.loads(post(server, "/v1/plans", frame))["camera"]
        depth = numbers(post(server, "/v1/frames", frame))
        worst, points = 0.0, []
        for row in range(camera["height"]):
            for column in range(camera["width"]):
                u, v = column + 0.5, row + 0.5
                direction = ray(camera, u, v)
                if direction is None:
                    continue
                worst = max(worst, math.dist((u, v), pixel(camera, direction)))
                if depth[row][column] > 0:
                    points.append(point(camera, u, v, depth[row][column]))
        low = [round(min(p[i] for p in points), 3) for i in range(3)]
        high = [round(max(p[i] for p in points), 3) for i in range(3)]
        print(f"{lens['type']}: pixels return within {worst:.1e}; {len(points)} points from {low} to {high}")


if __name__ == "__main__":
    main()
