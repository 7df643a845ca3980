#!/bin/sh
# Renders a small picture of each preset: scripts/preset_pictures.sh [NAME...]; by default all. The
# exposure is chosen for each fur, as a photographer would. PELAGE names the program.
set -eu
cd "$(dirname "$0")/.."
pelage=${PELAGE:-target/release/pelage}
[ $# -gt 0 ] || set -- $("$pelage" presets | cut -d ' ' -f 1)
mkdir -p docs/images/presets
for preset; do
    case $preset in
        arctic_fox | polar_bear) stops=-1.6 ;;
        rabbit) stops=-0.8 ;;
        black_cat) stops=3.5 ;;
        *) stops=0.2 ;;
    esac
    "$pelage" render scenes/species.toml -D preset="$preset" --size 160x120 --spp 4 --exposure "$stops" \
        -D camera.fov=24 -D environment.lights=4 -D 'film.background_color=[0.2, 0.2, 0.2]' \
        -o "docs/images/presets/$preset.png"
done
