#!/bin/sh
# Exports a scene, renders it with Mitsuba from a throw-away environment, and compares it with this program's ground truth.
#   scripts/witness/compare.sh [SCENE [arguments of mitsuba_compare.py]]
# Not part of the tests: it downloads Mitsuba (about 60 MB).
set -eu
cd "$(dirname "$0")/../.."
scene=${1:-scenes/witness.toml}
[ $# -gt 0 ] && shift
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT INT TERM
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q mitsuba==3.9.1 numpy
cargo build --release -q
target/release/pelage export "$scene" --to mitsuba --environment lights -o "$folder/exported"
target/release/pelage reference "$scene" --integrator single --spp 256 -o "$folder/ours.exr"
"$folder/venv/bin/python" scripts/witness/mitsuba_compare.py "$folder/exported/scene.xml" "$folder/ours.exr" "$@"
