#!/usr/bin/env python3
"""Compares the mean opacity of exported guard hairs by random rays with that of the image.

    pelage export scenes/cylinder.toml --strands pelt.hair --mesh pelt.obj
    pelage render scenes/cylinder.toml --fur explicit -D film.background=transparent -D film.filter=box -o pelt.exr
    scripts/witness/coverage.py pelt.exr pelt.hair --mesh pelt.obj

An independent check. Every strand segment is projected as the camera-facing ribbon of its cone. The
opacity of a random point of the film is 1 - prod(1 - opacity of each hair that covers it). Pixels
within three pixels of the mesh are left out, so that hidden hair and bare skin do not count. The
camera comes from the scene stored in the EXR file. Needs numpy only, and shares no code with pelage.
Exit code 1 if the means differ by more than --tolerance (1 %).
"""

import argparse
import struct
import sys
import tomllib
import zlib

import numpy as np


def read_exr(path):
    """Planes and text attributes of a single-part scanline EXR, uncompressed or ZIP."""
    data = open(path, "rb").read()
    if struct.unpack_from("<I", data)[0] != 20000630:
        sys.exit(f"{path}: not an OpenEXR file")
    at, attributes = 8, {}

    def text():
        nonlocal at
        end = data.index(b"\0", at)
        found, at = data[at:end].decode(), end + 1
        return found

    while data[at]:
        name, kind = text(), text()
        size = struct.unpack_from("<i", data, at)[0]
        attributes[name] = (kind, data[at + 4 : at + 4 + size])
        at += 4 + size
    at += 1
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"][1])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    compression = attributes["compression"][1][0]
    lines = {0: 1, 2: 1, 3: 16}.get(compression)
    if lines is None:
        sys.exit(f"{path}: compression {compression} is not supported, only none and ZIP")
    channels, raw, i = [], attributes["channels"][1], 0
    while raw[i]:
        end = raw.index(b"\0", i)
        channels.append((raw[i:end].decode(), {1: "<f2", 2: "<f4", 0: "<u4"}[struct.unpack_from("<i", raw, end + 1)[0]]))
        i = end + 1 + 16
    planes = {name: np.zeros((height, width), np.float32) for name, _ in channels}
    blocks = (height + lines - 1) // lines
    for offset in struct.unpack_from(f"<{blocks}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        block = data[offset + 8 : offset + 8 + size]
        rows = min(lines, height - (y - y0))
        expected = rows * width * sum(np.dtype(t).itemsize for _, t in channels)
        if size < expected:
            packed = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
            packed[1:] -= 128
            packed = np.cumsum(packed).astype(np.uint8)
            half = (len(packed) + 1) // 2
            whole = np.empty_like(packed)
            whole[0::2], whole[1::2] = packed[:half], packed[half:]
            block = whole.tobytes()
        i = 0
        for row in range(rows):
            for name, dtype in channels:
                planes[name][y - y0 + row] = np.frombuffer(block, dtype, width, i)
                i += width * np.dtype(dtype).itemsize
    return planes, {k: v.decode("utf-8", "replace") for k, (t, v) in attributes.items() if t == "string"}


def read_hair(path):
    """Points (strand, vertex, xyz), radius and opacity of strands with equal numbers of segments."""
    data = open(path, "rb").read()
    if data[:4] != b"HAIR":
        sys.exit(f"{path}: not a HAIR file")
    strands, points, flags, segments = struct.unpack_from("<4I", data, 4)
    thickness, transparency = struct.unpack_from("<2f", data, 20)
    at = 128
    if flags & 1:
        counts = np.frombuffer(data, "<u2", strands, at)
        at += 2 * strands
        if counts.min() != counts.max():
            sys.exit(f"{path}: strands of different numbers of segments are not supported")
        segments = int(counts[0])
    shape = (strands, segments + 1)

    def array(bit, per_point, default):
        nonlocal at
        if not flags & bit:
            return np.full(points * per_point, default)
        found = np.frombuffer(data, "<f4", points * per_point, at).astype(float)
        at += 4 * points * per_point
        return found

    xyz = array(2, 3, 0.0).reshape(*shape, 3)
    diameter = array(4, 1, thickness).reshape(shape)
    opacity = 1.0 - array(8, 1, transparency).reshape(shape)
    return xyz, 0.5 * diameter, opacity


class Camera:
    def __init__(self, spec, width, height):
        eye, target, up = (np.array(spec[k], float) for k in ("eye", "target", "up"))
        self.eye, self.forward = eye, (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(self.forward, up)
        self.right = right / np.linalg.norm(right)
        self.up = np.cross(self.right, self.forward)
        self.scale = 0.5 * height / np.tan(np.radians(spec["fov"]) / 2)
        self.centre = np.array([width / 2, height / 2])

    def project(self, points):
        v = points - self.eye
        z = v @ self.forward
        return self.centre + self.scale * np.stack([v @ self.right, -(v @ self.up)], -1) / z[..., None], z


def near_mesh(path, camera, shape, margin=3):
    """Pixels within `margin` of the bounding boxes of the mesh's projected triangles (a safe superset)."""
    vertices, triangles = [], []
    for line in open(path):
        word = line.split()
        if word[:1] == ["v"]:
            vertices.append([float(x) for x in word[1:4]])
        elif word[:1] == ["f"]:
            corners = [int(w.split("/")[0]) - 1 for w in word[1:]]
            triangles += [[corners[0], a, b] for a, b in zip(corners[1:], corners[2:])]
    xy, _ = camera.project(np.array(vertices))
    corners = xy[np.array(triangles)]
    low = np.floor(corners.min(1)).astype(int) - margin
    high = np.ceil(corners.max(1)).astype(int) + margin
    mask = np.zeros(shape, bool)
    for (x0, y0), (x1, y1) in zip(low, high):
        mask[max(y0, 0) : max(y1, 0), max(x0, 0) : max(x1, 0)] = True
    return mask


CELL = 4  # pixels


def opacity_of_points(points, xy, radius, opacity, shape):
    """Opacity at film points behind all ribbons that cover them."""
    columns, rows = -(-shape[1] // CELL), -(-shape[0] // CELL)
    cell = (points[:, 1] // CELL).astype(int) * columns + (points[:, 0] // CELL).astype(int)
    order = np.argsort(cell, kind="stable")
    points = points[order]
    first = np.searchsorted(cell[order], np.arange(columns * rows + 1))
    log_through = np.zeros(len(points))
    a, b = xy[:, :-1].reshape(-1, 2), xy[:, 1:].reshape(-1, 2)
    ra, rb = radius[:, :-1].ravel(), radius[:, 1:].ravel()
    oa, ob = opacity[:, :-1].ravel(), opacity[:, 1:].ravel()
    reach = np.maximum(ra, rb)[:, None]
    limit = np.array([columns, rows])
    low = np.clip(np.floor((np.minimum(a, b) - reach) / CELL).astype(int), 0, limit)
    high = np.clip(np.floor((np.maximum(a, b) + reach) / CELL).astype(int) + 1, 0, limit)
    size = np.maximum(high - low, 0)
    for start in range(0, len(a), 40_000):
        part = slice(start, start + 40_000)
        # Pairs of a segment and a cell of its bounding box, then of a segment and a point of that cell.
        count = size[part].prod(1)
        segment = np.repeat(np.arange(len(count)), count)
        k = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        wide = size[part][segment, 0]
        where = (low[part][segment, 1] + k // np.maximum(wide, 1)) * columns + low[part][segment, 0] + k % np.maximum(wide, 1)
        count = first[where + 1] - first[where]
        pair = np.repeat(segment, count) + start
        point = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first[where], count)
        along, from_a = b[pair] - a[pair], points[point] - a[pair]
        length2 = np.maximum((along**2).sum(1), 1e-12)
        t = (from_a * along).sum(1) / length2
        across = np.abs(from_a[:, 0] * along[:, 1] - from_a[:, 1] * along[:, 0]) / np.sqrt(length2)
        hit = (t >= 0) & (t < 1) & (across < ra[pair] * (1 - t) + rb[pair] * t)
        pair, point, t = pair[hit], point[hit], t[hit]
        o = np.minimum(oa[pair] * (1 - t) + ob[pair] * t, 1 - 1e-9)
        np.add.at(log_through, point, np.log1p(-o))
    result = np.empty(len(points))
    result[order] = 1 - np.exp(log_through)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("image", help="EXR written by pelage with --fur explicit")
    parser.add_argument("strands", help="HAIR file written by pelage export")
    parser.add_argument("--mesh", help="OBJ file written by pelage export: its pixels are left out")
    parser.add_argument("--crop", default="0,1,0,1", help="x0,x1,y0,y1 in 0..1")
    parser.add_argument("--samples", type=int, default=8, help="points a pixel")
    parser.add_argument("--tolerance", type=float, default=0.01, help="largest relative difference")
    parser.add_argument("--thicker", type=float, default=1.0, help="factor on the diameters, to see the check fail")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()

    planes, attributes = read_exr(args.image)
    alpha = planes["A"].astype(float)
    height, width = alpha.shape
    scene = tomllib.loads(attributes["pelage.scene"])
    camera = Camera(scene["camera"], width, height)
    x0, x1, y0, y1 = (float(x) for x in args.crop.split(","))
    chosen = np.zeros(alpha.shape, bool)
    chosen[round(y0 * height) : round(y1 * height), round(x0 * width) : round(x1 * width)] = True
    if args.mesh:
        chosen &= ~near_mesh(args.mesh, camera, alpha.shape)
    if not chosen.any():
        sys.exit("no pixel is left: choose another --crop")

    xyz, radius, opacity = read_hair(args.strands)
    xy, z = camera.project(xyz)
    if z.min() <= 0:
        sys.exit("strands behind the eye are not supported")
    rng = np.random.default_rng(args.seed)
    rows, columns = np.nonzero(chosen)
    points = np.repeat(np.stack([columns, rows], -1).astype(float), args.samples, 0)
    points += rng.random(points.shape)
    seen = opacity_of_points(points, xy, args.thicker * radius * camera.scale / z, opacity, alpha.shape)

    ours, witness = alpha[chosen].mean(), seen.mean()
    # Pixels are independent draws given the fur; hairs are the same in both.
    error = seen.reshape(-1, args.samples).std(1, ddof=min(1, args.samples - 1)).mean() / np.sqrt(len(points))
    difference = witness / ours - 1
    print(f"{len(xyz)} strands, {chosen.sum()} pixels, {len(points)} points")
    print(f"image {ours:.6f}, witness {witness:.6f} +- {error:.6f}, difference {100 * difference:+.3f} %")
    if not abs(difference) <= args.tolerance:
        sys.exit(f"the means differ by more than {100 * args.tolerance:g} %")


if __name__ == "__main__":
    main()
