#!/bin/sh
# Renders a scene: installs what is missing, builds the release binary, renders, prints where the
# pictures are.
set -eu

if [ $# -eq 0 ]; then
    cat <<'TEXT'
usage: scripts/render.sh SCENE -o OUT [more arguments of `pelage render`]

  scripts/render.sh scenes/default.toml -o out.png
  scripts/render.sh scenes/hat.toml -o hat.exr -o hat.png --size 1920x1136 --fur hybrid
  scripts/render.sh --help    all arguments
TEXT
    exit 2
fi

. "$(dirname -- "$0")/setup.sh"
setup

code=0
"$pelage" render "$@" || code=$?

# Also after an interrupt, which writes the finished part.
case $code in
    0 | 130)
        before=
        for argument; do
            case $argument in
                --outfile=*) out=${argument#*=} ;;
                -o?*) out=${argument#-o} ;;
                *)
                    out=
                    case $before in -o | --outfile) out=$argument ;; esac ;;
            esac
            before=$argument
            case $out in
                '') continue ;;
                /*) ;;
                *) out=$PWD/$out ;;
            esac
            [ ! -f "$out" ] || say "picture: $out"
        done ;;
esac
exit "$code"
