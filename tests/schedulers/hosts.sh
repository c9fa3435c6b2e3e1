#!/bin/bash
# Workers on several machines that share a folder: without locks, with wrong clocks, with a lost machine, and on a full disk.
#
#   cargo build --release && sudo bash tests/schedulers/hosts.sh
#
# Needs root, a C compiler and the package faketime. A machine is a set of namespaces with a name, a network, processes and an
# identity of its kernel of its own. Results must be the bytes of one process.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
program=${LANDSCAPE:-$root/target/release/landscape}
work=$(mktemp -d)
cleanup() {
    cd /
    umount -q "$work/small" || true
    rm -rf "$work"
}
trap cleanup EXIT
cc -shared -fPIC -O1 -o "$work/nolock.so" "$root/tests/schedulers/nolock.c"
faketime=$(find /usr/lib -name 'libfaketime.so.1' | head -n 1)
[ -n "$faketime" ] || { echo 'libfaketime is missing: install faketime' >&2; exit 1; }
task="synth --object bottle_round -n 48 --seed 1 --drop 0 -q"

# machine NAME CLOCK ARGUMENTS...: runs the program on a machine of this name, whose clock is wrong by CLOCK.
machine() {
    local name=$1 clock=$2
    shift 2
    echo "$name" > "$work/$name.boot"
    unshare --mount --uts --net --ipc --pid --fork --kill-child bash -c '
        set -e
        hostname "$0"
        mount --bind "$1" /proc/sys/kernel/random/boot_id
        mount --bind "$1" /proc/sys/kernel/hostname
        export LD_PRELOAD="$2 $3" FAKETIME="$4" FAKETIME_DONT_FAKE_MONOTONIC=1
        shift 4
        exec "$@"' "$name" "$work/$name.boot" "$work/nolock.so" "$faketime" "$clock" "$program" "$@"
}

mkdir "$work/one" "$work/shared" "$work/small"
(cd "$work/one" && "$program" $task -o g.parquet)

cd "$work/shared"
machine east +3h $task --threads 1 --worker 1/3 -o g.parquet &
east=$!
machine west -2h $task --threads 1 --worker 2/3 -o g.parquet &
west=$!
# North is lost while it works, and never comes back.
machine north +0 $task --threads 1 --worker 3/3 -o g.parquet &
north=$!
until [ "$(stat -c %s g.parquet.workers/3-of-3-north*.journal 2> /dev/null || echo 0)" -gt 3000 ]; do sleep 0.05; done
kill -9 "$north"
wait "$north" || true
"$program" status g.parquet
wait "$east" "$west"
machine south +1d $task -o g.parquet
cmp g.parquet "$work/one/g.parquet"
echo 'hosts: without locks, with wrong clocks and a lost machine: the same bytes'

# A disk that is full: one sentence, and after there is room nothing is done again.
mount -t tmpfs -o size=24k none "$work/small"
cd "$work/small"
if "$program" $task --worker 1/1 -o g.parquet 2> "$work/said"; then
    echo 'hosts: the disk was never full' >&2
    exit 1
fi
cat "$work/said"
[ "$(wc -l < "$work/said")" = 1 ]
mount -o remount,size=8m "$work/small"
"$program" status g.parquet
"$program" $task -o g.parquet
cmp g.parquet "$work/one/g.parquet"
echo 'hosts: after a full disk: the same bytes'
