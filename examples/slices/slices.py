#!/usr/bin/env python3
"""Draws a long sequence in slices on several servers, and joins the slices.

    slices.py draw SEQUENCE.json FOLDER FIRST COUNT    frames FIRST to FIRST + COUNT - 1, as FOLDER/000000FIRST.tar
    slices.py join FOLDER OUTPUT.tar                   all slices as one file

SEQUENCE.json is the body of POST /v1/sequences. It is sent with `first` and `count`, and without `plans`, so that the joined
file is byte for byte what one server answers. The environment variable SERVERS lists addresses, separated by spaces. A slice
that a server does not finish is drawn again on the next one; a slice that exists is not drawn again. parallel.sh, slurm.sh
and kubernetes.yaml run the slices. Uses the standard library only.
"""
import http.client
import json
import os
import pathlib
import shutil
import sys
import time
import urllib.error
import urllib.request

BLOCK = 512  # bytes of a tar
TRIES = 60
SILENCE = 600  # seconds without a byte until the next server is tried; longer than any frame takes


def members(path):
    """Yields the name of each file of a tar, where its header begins, and its size. Raises ValueError if the end is missing."""
    with open(path, "rb") as tar:
        while True:
            start = tar.tell()
            header = tar.read(BLOCK)
            if header == bytes(BLOCK) and tar.read(BLOCK) == bytes(BLOCK):
                return
            if len(header) < BLOCK or header[257:262] != b"ustar":
                raise ValueError(f"{path} is not complete")
            size = int(header[124:136].rstrip(b"\0 "), 8)
            yield header[:100].rstrip(b"\0").decode(), start, size
            tar.seek(start + BLOCK + padded(size))


def padded(size):
    return (size + BLOCK - 1) // BLOCK * BLOCK


def manifest_of(path):
    """The last file of a slice: its place in the tar, and its text."""
    name, start, size = list(members(path))[-1]
    if name != "manifest.json":
        raise ValueError(f"{path} has no manifest")
    with open(path, "rb") as tar:
        tar.seek(start + BLOCK)
        return start, tar.read(size).decode()


# ---- drawing ---------------------------------------------------------------------------------


def draw(sequence, folder, first, count):
    body = json.loads(pathlib.Path(sequence).read_text())
    body.update(first=first, count=count, plans=False)
    target = pathlib.Path(folder) / f"{first:09d}.tar"
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.exists():
        return
    servers = os.environ.get("SERVERS", "http://localhost:8080").split()
    unfinished = target.with_suffix(f".{os.getpid()}.part")
    for attempt in range(TRIES):
        server = servers[(first // count + attempt) % len(servers)]
        try:
            receive(server, json.dumps(body).encode(), unfinished)
            unfinished.rename(target)  # atomic: a slice that exists is complete
            return
        except (OSError, ValueError, http.client.HTTPException) as error:
            unfinished.unlink(missing_ok=True)
            print(f"slice {first}: {server}: {error}", file=sys.stderr)
            time.sleep(retry_after(error))
    raise SystemExit(f"slice {first} was not finished by any server")


def receive(server, body, path):
    request = urllib.request.Request(server + "/v1/sequences", body, {"Content-Type": "application/json"})
    try:
        with urllib.request.urlopen(request, timeout=SILENCE) as answer, open(path, "wb") as file:
            shutil.copyfileobj(answer, file)
    except urllib.error.HTTPError as error:
        if error.code in (409, 429, 500, 502, 503, 504):
            raise
        raise SystemExit(error.read().decode()) from error
    failures = [frame for frame in json.loads(manifest_of(path)[1])["frames"] if "failure" in frame]
    if failures:
        raise ValueError(f"frame {failures[0]['index']}: {failures[0]['failure'].get('detail')}")


def retry_after(error):
    headers = getattr(error, "headers", None)
    return float(headers.get("Retry-After", 1)) if headers else 0.2


# ---- joining ---------------------------------------------------------------------------------


def join(folder, output):
    frames, following = [], 0
    with open(output, "wb") as joined:
        for path in sorted(pathlib.Path(folder).glob("*.tar")):
            end, text = manifest_of(path)
            indices = [frame["index"] for frame in json.loads(text)["frames"]]
            if indices != list(range(following, following + len(indices))):
                raise SystemExit(f"{path} does not begin with frame {following}: a slice is missing")
            following += len(indices)
            # Numbers keep their text.
            frames.append(text[text.index("[") + 1:text.rindex("]")].rstrip())
            with open(path, "rb") as slice_:
                copy(slice_, joined, end)
                header = slice_.read(BLOCK)
        if not frames:
            raise SystemExit(f"{folder} has no slices")
        manifest = ('{\n "frames": [' + ",".join(frames) + '\n ],\n "failures": 0\n}').encode()
        joined.write(header_of(header, len(manifest)) + manifest)
        joined.write(bytes(padded(len(manifest)) - len(manifest) + 2 * BLOCK))


def copy(source, target, size):
    while size > 0:
        part = source.read(min(size, 1 << 20))
        target.write(part)
        size -= len(part)


def header_of(header, size):
    """The header with another size."""
    header = header[:124] + f"{size:011o}".encode() + header[135:148] + b" " * 8 + header[156:]
    return header[:148] + f"{sum(header):06o}".encode() + b"\0 " + header[156:]


match sys.argv[1:]:
    case ["draw", sequence, folder, first, count]:
        draw(sequence, folder, int(first), int(count))
    case ["join", folder, output]:
        join(folder, output)
    case _:
        raise SystemExit(__doc__)
