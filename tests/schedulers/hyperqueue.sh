#!/bin/bash
# Runs docs/cluster/hq.py on this machine, and compares the bytes with those of one process.
#
#   cargo build --release && bash tests/schedulers/hyperqueue.sh PYTHON
#
# PYTHON is an interpreter with the package hyperqueue; by default one is made in a temporary folder.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
export LANDSCAPE=${LANDSCAPE:-$root/target/release/landscape}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python=${1:-}
if [ -z "$python" ]; then
    python3 -m venv "$work/python"
    python=$work/python/bin/python
    "$python" -m pip install --quiet hyperqueue
fi
mkdir "$work/desk" "$work/one"
cd "$work/desk"
for command in "synth --object ball -n 16 --seed 1 -o g.parquet" "build g.parquet --first 8"; do
    started=$(date +%s%N)
    # shellcheck disable=SC2086
    CPUS=1 "$python" "$root/docs/cluster/hq.py" --local 4 $command
    echo "hyperqueue: $command took $((($(date +%s%N) - started) / 1000000)) ms"
    cat landscape-join.log
    (cd "$work/one" && "$LANDSCAPE" $command -q)
done
cmp g.parquet "$work/one/g.parquet"
diff -rq -x timings.json g.landscape "$work/one/g.landscape"
echo "hyperqueue: the same bytes as one process"
