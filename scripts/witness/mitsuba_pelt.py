#!/usr/bin/env python3
"""Path-traces exported guard hairs with Mitsuba 3 and prints the time and memory that it takes.

    pip install mitsuba==3.9.1
    pelage export scenes/cylinder.toml --strands pelt.hair
    pelage check scenes/cylinder.toml > pelt.toml
    scripts/witness/mitsuba_pelt.py pelt.hair pelt.toml --spp 16

Guard hairs alone (no undercoat, no skin), Chiang's hair model, at most 9 bounces, lights and camera
of the scene. The curves are uniform cubic B-splines through the exported vertices: Mitsuba's linear
curves are too bright on tapered hair. CPU seconds are user and system time of this process over all
threads; wall time depends on the load of the machine.
"""

import argparse
import os
import resource
import sys
import tempfile
import time
import tomllib

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from coverage import read_hair  # noqa: E402


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def through_vertices(values):
    """Control points of uniform cubic B-splines that pass through values[:, k], with straight ends."""
    n = values.shape[1]
    matrix = np.eye(n)
    for i in range(1, n - 1):
        matrix[i, i - 1 : i + 2] = [1 / 6, 4 / 6, 1 / 6]
    inner = np.einsum("ij,sjk->sik", np.linalg.inv(matrix), values)
    before = 2 * inner[:, :1] - inner[:, 1:2]
    after = 2 * inner[:, -1:] - inner[:, -2:-1]
    return np.concatenate([before, inner, after], 1)


def write_curves(path, xyz, radius, kind):
    curves = np.concatenate([xyz, radius[..., None]], 2)
    if kind == "bspline":
        curves = through_vertices(curves)
    curves[..., 3] = np.maximum(curves[..., 3], 1e-5)
    with open(path, "w") as out:
        for curve in curves:
            out.write("\n".join("%.6f %.6f %.6f %.7f" % tuple(p) for p in curve) + "\n\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("strands", help="HAIR file written by pelage export")
    parser.add_argument("scene", help="resolved scene printed by pelage check")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--depth", type=int, default=9, help="Mitsuba's max_depth")
    parser.add_argument("--size", default="", help="WxH; not given: the scene's")
    parser.add_argument("--curve", choices=["bspline", "linear"], default="bspline")
    parser.add_argument("--variant", default="scalar_rgb", help="scalar_rgb, or llvm_ad_rgb where LLVM 19 is installed")
    parser.add_argument("-o", "--outfile", help="EXR or PNG file")
    args = parser.parse_args()

    import mitsuba as mi

    mi.set_variant(args.variant)
    with open(args.scene, "rb") as file:
        scene = tomllib.load(file)
    xyz, radius, _ = read_hair(args.strands)
    width, height = map(int, args.size.split("x")) if args.size else (scene["film"]["width"], scene["film"]["height"])
    camera = scene["camera"]
    description = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": args.depth},
        "sensor": {
            "type": "perspective",
            "fov": camera["fov"],
            "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(origin=camera["eye"], target=camera["target"], up=camera["up"]),
            "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "gaussian"}},
            "sampler": {"type": "independent", "sample_count": args.spp},
        },
    }
    for i, light in enumerate(scene.get("lights", [])):
        towards = [-x for x in light["direction"]]
        irradiance = {"type": "rgb", "value": light["irradiance"]}
        description[f"light{i}"] = {"type": "directional", "direction": towards, "irradiance": irradiance}
    if "environment" in scene:
        # A map is replaced by a sky of its tint: the cost hardly depends on it.
        sky = scene["environment"]
        radiance = [sky["intensity"] * t for t in sky["tint"]]
        description["sky"] = {"type": "constant", "radiance": {"type": "rgb", "value": radiance}}

    with tempfile.TemporaryDirectory() as folder:
        curves = os.path.join(folder, "curves.txt")
        write_curves(curves, xyz, radius, args.curve)
        description["hair"] = {
            "type": f"{args.curve}curve",
            "filename": curves,
            "bsdf": {"type": "hair", "eumelanin": 1.3, "pheomelanin": 0.3},
        }
        start, wall = cpu_seconds(), time.time()
        loaded = mi.load_dict(description)
    load_cpu, load_wall = cpu_seconds() - start, time.time() - wall
    start, wall = cpu_seconds(), time.time()
    image = mi.render(loaded)
    mean = np.array(image)[..., :3].mean()
    render_cpu, render_wall = cpu_seconds() - start, time.time() - wall
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    if args.outfile:
        mi.util.write_bitmap(args.outfile, image)
    print(f"mitsuba {mi.__version__} {args.variant}, {os.cpu_count()} cores")
    print(f"{len(xyz)} strands of {xyz.shape[1] - 1} segments ({args.curve}), {width} x {height}, {args.spp} spp, depth {args.depth}")
    print(f"load   {load_cpu:8.1f} CPU s {load_wall:8.1f} s")
    print(f"render {render_cpu:8.1f} CPU s {render_wall:8.1f} s")
    print(f"peak   {peak:8.0f} MiB, mean {mean:.5f}")


if __name__ == "__main__":
    main()
