#!/bin/sh
# Bakes web/shells/test.toml, shows it on the page of web/shells in headless Chromium, and compares
# that picture with `pelage render --fur shells` of the same view. Installs Node.js, Chromium and the
# npm packages if they are missing.
#
#   scripts/web_shells.sh                 pictures go to out/web_shells
#   CHROMIUM=/path/to/chrome scripts/web_shells.sh
set -eu

. "$(dirname -- "$0")/setup.sh"
. "$(dirname -- "$0")/browser.sh"

# Largest difference allowed: the page filters with four samples per pixel and lights the vertices.
most_flip=${MOST_FLIP:-0.02}

setup
need_packages "$root/web/shells"
need_chromium
out=$root/out/web_shells
mkdir -p "$out/fur"
scene=$root/web/shells/test.toml

"$pelage" bake "$scene" -o "$out/fur" --formats ktx2 --gltf --quiet
node "$root/web/shells/test.mjs" "$out/fur" "$out/page.png"
"$pelage" render "$scene" --fur shells -o "$out/pelage.png" --quiet
"$pelage" compare "$out/page.png" "$out/pelage.png" --threshold-flip "$most_flip" -o "$out/flip.png"
say "pictures: $out/page.png, pelage.png, flip.png"
