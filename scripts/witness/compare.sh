#!/bin/sh
# Renders a scene with Mitsuba from a throw-away environment and compares it with pelage's ground
# truth: first lit from the side, then lit from above and seen from another place; each with single
# scattering and with all orders. Ends with two comparisons that must fail.
#   scripts/witness/compare.sh, optionally with the path of another scene
# MITSUBA names a Python that has mitsuba and numpy; without it they are downloaded (about 60 MB).
# Takes a few minutes. Not part of the tests. Exit code 1 if a limit is exceeded.
set -eu
cd "$(dirname "$0")/../.."
scene=${1:-scenes/witness.toml}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT INT TERM
python=${MITSUBA:-}
if [ -z "$python" ]; then
    python3 -m venv "$folder/venv"
    "$folder/venv/bin/pip" install -q mitsuba==3.9.1 numpy
    python=$folder/venv/bin/python
fi
cargo build --release -q

failed=0
# compare NAME INTEGRATOR [arguments of mitsuba_compare.py]
compare() {
    name=$1-$2
    exported=$folder/$1/scene.xml
    shift 2
    echo "== $name $*"
    "$python" scripts/witness/mitsuba_compare.py "$exported" "$folder/$name.exr" "$@"
}
# prepare NAME [-D KEY=VALUE ...]
prepare() {
    name=$1
    shift
    target/release/pelage -q export "$scene" "$@" --to mitsuba --environment lights -o "$folder/$name" >/dev/null
    for integrator in single path; do
        target/release/pelage -q reference "$scene" "$@" --integrator "$integrator" --lights scene --spp 256 -o "$folder/$name-$integrator.exr"
    done
}
prepare side
prepare above -D lights.0.direction=[0.3,1,0.5] -D camera.eye=[1.2,2.4,3.6]
for light in side above; do
    compare $light single --spp 256 || failed=1
    # Rays leave from the axis here and from the surface there, which affects how often light
    # scatters again.
    compare $light path --spp 256 --depth 64 --radiance 0.05 || failed=1
done
for wrong in --brighter=1.02 --tilt=-2; do
    if compare above single --spp 64 "$wrong"; then
        echo "$wrong was not noticed" >&2
        failed=1
    fi
done
[ $failed = 0 ] && echo "agrees; both wrong witnesses were noticed"
exit $failed
