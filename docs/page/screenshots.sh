#!/usr/bin/env bash
# Makes the pictures of this folder from pages: docs/page/screenshots.sh GRASPS.report.html MULLER-BROWN.report.html
# Needs chromium.
set -euo pipefail
grasps=$(realpath "$1")
surface=$(realpath "$2")
cd "$(dirname "$0")"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shot NAME PAGE WIDTHxHEIGHT FRAGMENT
shot() {
  chromium --headless --no-sandbox --disable-gpu --enable-unsafe-swiftshader --disable-quic --no-first-run \
    --disable-background-networking --disable-component-update --disable-sync --hide-scrollbars \
    --user-data-dir="$work/profile $1" --window-size="${3/x/,}" --virtual-time-budget=8000 \
    --screenshot="$PWD/$1.png" "file://$2#$4" 2> "$work/log"
}

shot way "$grasps" 1440x1000 'sel=m3,m17&step=0.62'
shot families "$grasps" 1440x760 'sel=m3&level=0.25'
shot narrow "$grasps" 390x1200 'sel=m3'
shot surface "$surface" 1440x1000 'sel=m0,m1&step=0.3'
ls -l ./*.png
