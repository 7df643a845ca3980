#!/bin/sh
# Downloads the assets that scenes and figures name, from pinned public addresses, and checks their
# SHA-256 sums. Files that are present and correct are left alone; a new file appears complete and
# checked, or not at all.
set -eu

usage() {
    cat <<'END'
usage: scripts/fetch_assets.sh [--list | --check] [--into FOLDER] [NAME...]

Downloads the named files, or all of them, into FOLDER (default: assets/ of the repository).
  --list    show the files, their addresses and licences, and download nothing
  --check   check the files that are in FOLDER, and download nothing
  NAME      a file as --list shows it, such as meshes/stanford-bunny.obj, or a folder, such as env

Needs curl or wget, sha256sum or shasum, and unzip for the meshes called spot.
Exit code: 0 all files are present and correct; 1 some are not; 2 wrong usage.
END
}

# Sum, file, address relative to the base (after # a member of the zip archive), licence as the
# origin states it.
base=https://raw.githubusercontent.com
files() {
    cat <<'END'
77a64d58dd57475d2f0def31b1d4a8749dd7f223b5cb8875d67bb03972c61a04|env/brown_photostudio_02_1k.hdr|gkjohnson/3d-demo-data/a79b5400ba8ed5bdeffebc10ce5adeecda7c3ebc/hdri/brown_photostudio_02_1k.hdr|Poly Haven (CC0 there)
463b0ab0c03632762e1fb168fbf05162aaa1c2d2d8d8b36b10bc1806d2257243|env/chinese_garden_1k.hdr|gkjohnson/3d-demo-data/a79b5400ba8ed5bdeffebc10ce5adeecda7c3ebc/hdri/chinese_garden_1k.hdr|Poly Haven (CC0 there)
8aa8cf02f8cc098318efa8668436b9d4b1a106499dce7b26f1a858f0f1091313|env/noon_grass_1k.hdr|gkjohnson/3d-demo-data/a79b5400ba8ed5bdeffebc10ce5adeecda7c3ebc/hdri/noon_grass_1k.hdr|Poly Haven (CC0 there)
1eb35d1e21ce99e5ce911353b6be278990713448dd9e8f5c9387f9de39b32205|meshes/stanford-bunny.obj|alecjacobson/common-3d-test-models/8a4f8642acaf43f9cd7b67858a1502e1055ef202/data/stanford-bunny.obj|Stanford terms: research use, credit the Stanford Computer Graphics Laboratory
966866fd198ba81f055f6fe4c03278f1b4991fee793317ad9553c07435fb2961|meshes/bunny-closed-60k.obj|odedstein/meshes/835213277571d625722d25880c9c3010c6f45a5a/objects/bunny/bunny_hr.obj|Stanford terms: research use, credit the Stanford Computer Graphics Laboratory
17200138dad1ad0f86ef9a98dd38f9932098b2c9e94d8694bd3f6143601e8c54|meshes/armadillo-29k.obj|odedstein/meshes/835213277571d625722d25880c9c3010c6f45a5a/objects/armadillo/armadillo.obj|Stanford terms: research use, credit the Stanford Computer Graphics Laboratory
543b94dfe485d6f0661111b9fc063d627b11d24898f07ff6fd91e25211bbbfc7|meshes/cat.obj|odedstein/meshes/835213277571d625722d25880c9c3010c6f45a5a/objects/cat/cat-low-resolution.obj|CC BY 4.0, billyd
bb9e378e4268c9e21460f7b022b4113f0e06eb6dd1e0254cc471236294d398a2|meshes/cheburashka.obj|odedstein/meshes/835213277571d625722d25880c9c3010c6f45a5a/objects/stuffedtoy/stuffedtoy.obj|libigl terms (MPL 2.0) as the origin says; Ilya Baran / Cosmic Blobs
5fabbceb4fb27534f0a15077e305b65bf0fcab83f188c90fd71a9c86f9ca7e3a|meshes/spot-23k.obj|odedstein/meshes/835213277571d625722d25880c9c3010c6f45a5a/objects/spot/spot.obj|public domain, Keenan Crane
d8684326f9bd8cfc24d3d302c1042fa16f63d2e66e49ed56b413fa20bed271e6|meshes/suzanne.obj|alecjacobson/common-3d-test-models/8a4f8642acaf43f9cd7b67858a1502e1055ef202/data/suzanne.obj|none stated (a Blender primitive)
a176f0223a6e74e90185c067ed45f928257e775cad7e17687ed4612a3343c206|meshes/spider.obj|assimp/assimp/21bea12f1278090c09a94c39ca090d9fb458ccd9/test/models/OBJ/spider.obj|BSD 3-Clause (repository)
64f270152d0f7d70cd635e8f074f73f0d62f0432e05ead7a0a8a80290a61f1d3|meshes/spider.mtl|assimp/assimp/21bea12f1278090c09a94c39ca090d9fb458ccd9/test/models/OBJ/spider.mtl|BSD 3-Clause (repository)
618d0146236cd0bc8a544bd2273fe47540724f0a99c5741b0bfec3384689e7ae|hair/straight.hair|fannliu/liusalon/1bb592ab0417c57cb352f416f75ce05477b5e341/LiuSalon/LiuSalon/model/straight.hair|personal or research use; link to www.cemyuksel.com/research/hairmodels; no redistribution
596aa1e7cb875eb79f437e310381d26b338a81c2da23439704a73c4651e8c4bb|photos/chelsea.png|scikit-image/scikit-image/60764df36c34c5202554aae507722836b6108d10/skimage/data/chelsea.png|CC0, Stefan van der Walt
bc34a3ce58dea09dce1704c997171602de90cb34d0c8503a988b77f473d39b08|plates/kodim13.png|MohamedBakrAli/Kodak-Lossless-True-Color-Image-Suite/dd2e1105fe8d9afe1120cd7e4c0e5e41f509a81b/PhotoCD_PCD0992/13.png|released by Eastman Kodak for unrestricted use, as the origin understands
1cee58eb1f2d9c7ebb254d208a03c783ce6cf2c4d8c2cf45e235dd23b4ce1b29|plates/kodim22.png|MohamedBakrAli/Kodak-Lossless-True-Color-Image-Suite/dd2e1105fe8d9afe1120cd7e4c0e5e41f509a81b/PhotoCD_PCD0992/22.png|released by Eastman Kodak for unrestricted use, as the origin understands
0738b5e8608fed74e5e8c7aa8dd0af97b4b74f9f6cbf7aac84cd7e40b2e44a75|meshes/spot.obj|alecjacobson/common-3d-test-models/8a4f8642acaf43f9cd7b67858a1502e1055ef202/data/spot.zip#spot_triangulated.obj|public domain, Keenan Crane
08bf90be56612f0d2643a75a8764c4ca8fac7fe983ab91b53b51d37981e5757c|meshes/spot-quads.obj|alecjacobson/common-3d-test-models/8a4f8642acaf43f9cd7b67858a1502e1055ef202/data/spot.zip#spot_quadrangulated.obj|public domain, Keenan Crane
cddabbae52a666173e7953e238b88340d285044dc20b36f8ed3f1a41db534fa5|meshes/spot_texture.png|alecjacobson/common-3d-test-models/8a4f8642acaf43f9cd7b67858a1502e1055ef202/data/spot.zip#spot_texture.png|public domain, Keenan Crane
END
}

mode=fetch
into=
names=
while [ $# -gt 0 ]; do
    case $1 in
        -h | --help) usage; exit 0 ;;
        --list) mode=list ;;
        --check) mode=check ;;
        --into)
            [ $# -ge 2 ] || { echo "fetch_assets: --into needs a folder" >&2; exit 2; }
            into=$2
            shift ;;
        -*) echo "fetch_assets: unknown option $1" >&2; usage >&2; exit 2 ;;
        *)
            case $1 in *[!A-Za-z0-9._/-]*) echo "fetch_assets: unknown file $1" >&2; exit 2 ;; esac
            names="$names ${1%/}" ;;
    esac
    shift
done
[ -n "$into" ] || into=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)/assets

# Whether the file $1 is asked for.
wanted() {
    [ -n "$names" ] || return 0
    for name in $names; do
        case $1 in "$name" | "$name"/*) return 0 ;; esac
    done
    return 1
}

for name in $names; do
    files | cut -d'|' -f2 | grep -q -x -e "$name" -e "$name/.*" || {
        echo "fetch_assets: unknown file $name (--list shows all)" >&2
        exit 2
    }
done

sum_of() {
    if command -v sha256sum >/dev/null; then sha256sum <"$1"; else shasum -a 256 <"$1"; fi | cut -d' ' -f1
}

download() {
    if command -v curl >/dev/null; then
        curl --fail --location --silent --show-error --retry 3 --connect-timeout 20 --output "$2" "$1"
    elif command -v wget >/dev/null; then
        wget --quiet --tries=3 --timeout=20 --output-document="$2" "$1"
    else
        echo "fetch_assets: needs curl or wget" >&2
        return 1
    fi
}

# Downloads the address $1 into the file $2, out of its archive if it names one.
get() {
    case $1 in
        *'#'*)
            command -v unzip >/dev/null || { echo "fetch_assets: needs unzip for ${1##*/}" >&2; return 1; }
            archive=$temporary/$(echo "${1%%#*}" | tr / _)
            [ -f "$archive" ] || download "$base/${1%%#*}" "$archive" || { rm -f "$archive"; return 1; }
            # The member may be in a folder of the archive; unzip returns 11 if a pattern matches nothing.
            unzip -p -q "$archive" "${1##*#}" "*/${1##*#}" >"$2" 2>/dev/null || [ $? -eq 11 ] ;;
        *) download "$base/$1" "$2" ;;
    esac
}

temporary=
trap '[ -z "$temporary" ] || rm -rf "$temporary"' EXIT
trap 'exit 130' INT TERM
if [ "$mode" = fetch ]; then
    mkdir -p "$into"
    # In the same folder, so that moving a finished file is atomic.
    temporary=$(mktemp -d "$into/.fetch.XXXXXX")
fi

failed=0
while IFS='|' read -r sum file address licence; do
    wanted "$file" || continue
    target=$into/$file
    if [ "$mode" = list ]; then
        printf '%s\n  %s/%s\n  licence: %s\n' "$file" "$base" "$address" "$licence"
        continue
    fi
    if [ -f "$target" ] && [ "$(sum_of "$target")" = "$sum" ]; then
        echo "ok       $file"
        continue
    fi
    if [ "$mode" = check ]; then
        if [ -f "$target" ]; then echo "WRONG    $file"; else echo "missing  $file"; fi
        failed=1
        continue
    fi
    echo "fetching $file ($licence)"
    part=$temporary/part
    rm -f "$part"
    # Standard input is the list of files.
    if ! get "$address" "$part" </dev/null; then
        echo "FAILED   $file: $base/$address" >&2
        failed=1
    elif [ "$(sum_of "$part")" != "$sum" ]; then
        echo "WRONG    $file: the download has SHA-256 $(sum_of "$part"), expected $sum; not kept" >&2
        failed=1
    else
        mkdir -p "$(dirname "$target")"
        mv -f "$part" "$target"
    fi
done <<END
$(files)
END

if [ "$mode" = fetch ]; then
    echo "The licences are those that the origins state (--list); credit the authors in what you publish."
fi
exit $failed
