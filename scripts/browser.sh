# Sourced after setup.sh by scripts that show a page in Chromium: installs Node.js, Chromium and npm
# packages if they are missing.

# need_packages FOLDER
need_packages() {
    command -v npm >/dev/null || install "no npm" "nodejs npm" "nodejs npm" "nodejs npm"
    (cd "$1" && npm ls >/dev/null 2>&1 || npm ci --silent) || fail "npm ci failed in $1"
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
