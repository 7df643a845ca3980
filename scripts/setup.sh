# Sourced by render.sh and test.sh: ensures that a Rust toolchain and a GPU adapter are present, and
# builds pelage.
#
# Installs distribution packages only if something is missing and if it can (as root or with sudo);
# otherwise it says what to install. Sets `root`, the repository, and `pelage`, the binary.

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)

say() {
    echo "$*" >&2
}

fail() {
    say "$(basename -- "$0"): $*"
    exit 1
}

# Runs a command as root; fails if that is impossible.
as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    elif ! command -v sudo >/dev/null; then
        return 1
    elif [ -t 0 ]; then
        sudo "$@"
    else
        # Nobody is there to type a password.
        sudo -n "$@"
    fi
}

# install WHY DEBIAN-PACKAGES FEDORA-PACKAGES ARCH-PACKAGES
install() {
    if command -v apt-get >/dev/null; then
        packages=$2
        by="apt-get install $packages"
    elif command -v dnf >/dev/null; then
        packages=$3
        by="dnf install $packages"
    elif command -v pacman >/dev/null; then
        packages=$4
        by="pacman -S $packages"
    else
        fail "$1. Please install it: Debian and Ubuntu call the packages $2, Fedora $3, Arch $4"
    fi
    say "$1: $by"
    log=$(mktemp)
    # shellcheck disable=SC2086 # A list of packages.
    case $by in
        apt-get*)
            as_root env DEBIAN_FRONTEND=noninteractive apt-get update -q &&
                as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $packages ;;
        dnf*) as_root dnf install -q -y $packages ;;
        pacman*) as_root pacman -Sy --noconfirm --needed $packages ;;
    esac >"$log" 2>&1 || {
        cat "$log" >&2
        rm -f "$log"
        fail "that did not work. Please run it as root: $by"
    }
    rm -f "$log"
}

need_rust() {
    command -v cargo >/dev/null || PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
    command -v cargo >/dev/null && command -v rustc >/dev/null ||
        fail "no Rust toolchain. Please install one with https://rustup.rs (version 1.88 or later)"
    # rustc links with the C compiler.
    command -v cc >/dev/null || install "no C compiler for linking" "gcc libc6-dev" "gcc" "gcc"
}

# Mesa's drivers print a warning without it.
need_runtime_folder() {
    [ -z "${XDG_RUNTIME_DIR:-}" ] || return 0
    XDG_RUNTIME_DIR=$(mktemp -d)
    export XDG_RUNTIME_DIR
    trap 'rm -rf "$XDG_RUNTIME_DIR"' EXIT
    # On an interrupt the running command shuts down first, then this script.
    trap : INT TERM
}

build() {
    # cargo resolves a relative folder against its working directory, which is the repository
    # (for its configuration and toolchain).
    profile=${profile:-release}
    folder=$profile
    [ "$profile" != dev ] || folder=debug
    pelage=${CARGO_TARGET_DIR:-$root/target}/$folder/pelage
    case $pelage in
        /*) ;;
        *) pelage=$root/$pelage ;;
    esac
    quiet=--quiet
    [ -x "$pelage" ] || quiet=
    # shellcheck disable=SC2086 # Empty, not an empty argument.
    (cd "$root" && cargo build --profile "$profile" --locked $quiet) || fail "the build failed"
}

# Installs Mesa's software adapter if no sufficient adapter is found.
need_adapter() {
    "$pelage" devices >/dev/null 2>&1 && return 0
    if [ "$(uname)" != Linux ]; then
        "$pelage" devices || fail "no adapter. Please install a driver for Metal, DirectX 12 or Vulkan"
    fi
    install "no GPU adapter answers; a software adapter will do" \
        "libvulkan1 mesa-vulkan-drivers" "vulkan-loader mesa-vulkan-drivers" "vulkan-icd-loader vulkan-swrast"
    "$pelage" devices >/dev/null || fail "no adapter answers, though a software adapter is installed"
}

# Fetched assets are found from every folder.
find_assets() {
    [ -z "${PELAGE_ASSETS:-}" ] && [ -d "$root/assets/meshes" ] || return 0
    PELAGE_ASSETS=$root/assets
    export PELAGE_ASSETS
}

setup() {
    need_rust
    need_runtime_folder
    find_assets
    build
    need_adapter
}
