#!/bin/sh
# Opens the report of `pelage figure` in headless Chromium and checks it: an empty console, every
# picture and link, every slider. Pictures of each figure's part and figures.pdf go to
# out/web_report. Installs Node.js, Chromium and an npm package if they are missing.
#
#   scripts/web_report.sh                    paper_figures/index.html, made small first if it is missing
#   scripts/web_report.sh FOLDER/index.html
set -eu

. "$(dirname -- "$0")/setup.sh"
. "$(dirname -- "$0")/browser.sh"

page=${1:-$root/paper_figures/index.html}
if [ ! -f "$page" ] && [ $# -eq 0 ]; then
    setup
    (cd "$root" && "$pelage" figure --all --quick)
fi
[ -f "$page" ] || fail "$page is not there: pelage figure --all writes it"
need_packages "$root/web/report"
need_chromium
node "$root/web/report/test.mjs" "$page" "$root/out/web_report"
say "pictures and figures.pdf: $root/out/web_report"
