#!/bin/sh
# Bakes web/shells/test.toml, shows it on the page of web/shells in headless Chromium, and compares that picture with
# `pelage render --fur shells` of the same view. Installs Node.js, Chromium and the npm packages where they are missing.
#
#   scripts/web_shells.sh                 pictures go to out/web_shells
#   CHROMIUM=/path/to/chrome scripts/web_shells.sh
set -eu

. "$(dirname -- "$0")/setup.sh"

# Most that the pictures may differ: the page filters with four samples a pixel and lights the vertices.
most_flip=${MOST_FLIP:-0.02}

need_node() {
    command -v npm >/dev/null || install "no npm" "nodejs npm" "nodejs npm" "nodejs npm"
    (cd "$root/web/shells" && npm ls >/dev/null 2>&1 || npm ci --silent) || fail "npm ci failed in web/shells"
}

need_chromium() {
    [ -z "${CHROMIUM:-}" ] || return 0
    for name in chromium chromium-browser google-chrome; do
        ! command -v "$name" >/dev/null || { CHROMIUM=$(command -v "$name"); break; }
    done
    if [ -z "${CHROMIUM:-}" ]; then
        install "no Chromium" "chromium" "chromium" "chromium"
        CHROMIUM=$(command -v chromium || command -v chromium-browser) || fail "Chromium is installed, but not found"
    fi
    export CHROMIUM
}

setup
need_node
need_chromium
out=$root/out/web_shells
mkdir -p "$out/fur"
scene=$root/web/shells/test.toml

"$pelage" bake "$scene" -o "$out/fur" --formats ktx2 --gltf --quiet
node "$root/web/shells/test.mjs" "$out/fur" "$out/page.png"
"$pelage" render "$scene" --fur shells -o "$out/pelage.png" --quiet
"$pelage" compare "$out/page.png" "$out/pelage.png" --threshold-flip "$most_flip" -o "$out/flip.png"
say "pictures: $out/page.png, pelage.png, flip.png"
