#!/bin/sh
# Installs what is missing, then checks format, lints and documentation and runs all tests.
#
#   scripts/test.sh             everything
#   scripts/test.sh FILTER...   only the tests whose names contain a filter, without the other checks
#
# Tests that need downloaded meshes and images look in PELAGE_ASSETS or in assets/, where
# scripts/fetch_assets.sh puts them; without them they print that they are skipped.
set -eu

. "$(dirname -- "$0")/setup.sh"
cd "$root"
begin=$(date +%s)

# Runs a step; its output is shown only if it fails, its notes always.
step() {
    name=$1
    shift
    started=$(date +%s)
    log=$(mktemp)
    if "$@" >"$log" 2>&1; then
        say "ok      $name ($(($(date +%s) - started)) s)$(summary)"
        rm -f "$log"
    else
        cat "$log" >&2
        rm -f "$log"
        fail "$name: failed (the output is above)"
    fi
}

# The counts of cargo test or nextest.
summary() {
    awk '/^test result: / { passed += $4; failed += $6; ignored += $8 }
        /Summary \[/ { sub(/.*\] */, ""); line = $0 }
        /^ *note: skipped/ { notes++ }
        END {
            if (line != "") printf ": %s", line
            else if (passed) printf ": %d passed, %d ignored", passed, ignored
            if (notes) printf "; %d notes of skipped parts", notes
        }' "$log"
}

# A component that a minimal toolchain lacks.
need_component() {
    cargo "$1" --version >/dev/null 2>&1 && return 0
    command -v rustup >/dev/null && rustup component add "$2" >/dev/null 2>&1 && return 0
    say "skipped $1: not installed (rustup component add $2)"
    return 1
}

# A few tests are run as in development: incremental, shaders read from the disk.
[ $# -eq 0 ] || profile=dev
say "building (the first time takes some minutes)"
setup
say "ok      build ($(($(date +%s) - begin)) s)"
"$pelage" devices >&2
[ -n "${PELAGE_ASSETS:-}" ] ||
    say "note: PELAGE_ASSETS is not set and assets/ is empty (scripts/fetch_assets.sh): some tests will be skipped"

if [ $# -gt 0 ]; then
    if cargo nextest --version >/dev/null 2>&1; then
        cargo nextest run --workspace --locked -- "$@"
    else
        cargo test --workspace --locked -- "$@"
    fi
    exit
fi

if need_component fmt rustfmt; then
    step "format" cargo fmt --all --check
fi
if need_component clippy clippy; then
    step "lints" cargo clippy --workspace --release --locked --all-targets --quiet -- -D warnings
fi
RUSTDOCFLAGS="-D warnings" step "documentation" cargo doc --workspace --release --locked --no-deps --lib --quiet
if cargo nextest --version >/dev/null 2>&1; then
    step "tests" cargo nextest run --workspace --release --locked --no-fail-fast --success-output final --hide-progress-bar
    step "examples in the documentation" cargo test --release --locked --doc --package pelage
else
    step "tests" cargo test --workspace --release --locked --no-fail-fast
fi
say "all is well ($(($(date +%s) - begin)) s)"
