#!/usr/bin/env python3
"""Reads the mattes of an EXR file as a compositor does, with another reader than pelage's.

    python3 -m venv /some/folder && /some/folder/bin/pip install OpenEXR numpy mmh3
    /some/folder/bin/python scripts/witness/cryptomatte.py a.exr [MATTE OUT.exr]

Prints the names of every set with their total coverage in pixels. Fails if an id is not that of its
name, if a pixel holds an id that the manifest lacks, or if the coverages of a pixel do not add up to
1 - transmittance.Y. With MATTE and OUT.exr, writes that matte as an image.
"""

import json
import sys

import mmh3
import numpy
import OpenEXR


def id_of(name):
    """The id of a name, as the bits of a float. Cryptomatte specification 1.2, hash and conversion."""
    bits = mmh3.hash(name.encode("utf-8"), 0, signed=False)
    if (bits >> 23) & 255 in (0, 255):
        bits ^= 1 << 23
    return bits


def main():
    path, *wanted = sys.argv[1:]
    with OpenEXR.File(path, separate_channels=True) as file:
        header = dict(file.header())
        channels = {name: channel.pixels.copy() for name, channel in file.channels().items()}
    keys = [name.split("/")[1] for name in header if name.startswith("cryptomatte/") and name.endswith("/name")]
    assert keys, "no cryptomatte/KEY/name in the header"
    visible = 1 - channels["transmittance.Y"].astype(numpy.float64)
    for key in sorted(keys):
        of = lambda attribute: header[f"cryptomatte/{key}/{attribute}"]
        name = of("name")
        assert key == f"{mmh3.hash(name.encode(), 0, signed=False):08x}"[:7], key
        assert (of("hash"), of("conversion")) == ("MurmurHash3_32", "uint32_to_float32")
        manifest = {int(bits, 16): matte for matte, bits in json.loads(of("manifest")).items()}
        for bits, matte in manifest.items():
            assert bits == id_of(matte), matte
        mattes = {matte: numpy.zeros(visible.shape) for matte in manifest.values()}
        levels = sorted(n for n in channels if n.startswith(name) and n.endswith(".r") and n[len(name):-2].isdigit())
        for level in levels:
            for ids, coverages in (("r", "g"), ("b", "a")):
                ids, coverages = channels[level[:-1] + ids], channels[level[:-1] + coverages]
                assert ids.dtype == coverages.dtype == numpy.float32
                bits = ids.view(numpy.uint32)
                assert all(int(b) in manifest for b in numpy.unique(bits[coverages > 0])), "an unknown id"
                for known, matte in manifest.items():
                    mattes[matte] += numpy.where(bits == known, coverages, 0)
        worst = numpy.abs(sum(mattes.values()) - visible).max()
        print(f"{name}: {len(levels)} levels; coverages differ from 1 - transmittance.Y by at most {worst:.1e}")
        for matte, coverage in mattes.items():
            print(f"  {matte}: {coverage.sum():.1f} pixels")
        assert worst < 1e-3
        if wanted and wanted[0] in mattes:
            matte = mattes[wanted[0]].astype(numpy.float32)
            with OpenEXR.File({"type": OpenEXR.scanlineimage}, {"Y": OpenEXR.Channel(matte)}) as out:
                out.write(wanted[1])


main()
