#!/usr/bin/env bash
# Makes the pictures of this folder and the loop of the README: docs/page/screenshots.sh [PROGRAM]
# Builds the pages with the program (by default target/release/landscape), which takes some minutes. Needs chromium, nodejs,
# webp from Debian, and a Python (PYTHON) with Pillow 10.1 or later. At the end callouts.py numbers parts of some pictures: look at them.
set -euo pipefail
program=$(realpath "${1:-$(dirname "$0")/../../target/release/landscape}")
cd "$(dirname "$0")"
pictures=$PWD
grasps=$(realpath ../../data/grasps.parquet)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/frames" "$work/pictures"
cd "$work"

cp "$grasps" grasps.parquet
"$program" build grasps.parquet -q
"$program" report grasps.landscape -q -o grasps.html
"$program" report grasps.parquet -q -o population.html
"$program" build grasps.parquet -q --first 60 --no-report -o first-60.landscape
"$program" build grasps.parquet -q --first 80 --no-report -o first-80.landscape
"$program" report first-60.landscape first-80.landscape -q -o two.html
surface() {
  local name=$1
  shift
  "$program" surface "$@" -q --no-report -o "$name.landscape"
  "$program" report "$name.landscape" -q -o "$name.html"
}
surface muller-brown muller-brown
surface double-well double-well 1 0.4
surface lj-7 lj 7
surface torsion torsion 1 3 1 3 1 2

node "$pictures/camera.mjs" "$work" "$work/pictures" "$work/frames"
img2webp -loop 0 -d 70 -lossy -q 78 -m 4 -kmin 30 -kmax 60 "$work"/frames/*.png -o "$work/pictures/loop.webp" > log
mv "$work"/pictures/*.webp "$pictures/"
${PYTHON:-python3} "$pictures/callouts.py"
ls -l "$pictures"/*.webp
