#!/bin/bash
# Workers on several machines that share a folder: without locks, over a network, with wrong clocks, with a lost machine, and on
# a full disk.
#
#   cargo build --release && sudo bash tests/schedulers/hosts.sh
#
# Needs root, a C compiler and the packages faketime, sshfs and openssh-server. A machine is a set of namespaces with a name, a
# network, processes and an identity of its kernel of its own. Results must be the bytes of one process.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
program=${LANDSCAPE:-$root/target/release/landscape}
work=$(mktemp -d)
cleanup() {
    cd /
    umount -q "$work/small" "$work"/mount-* || true
    [ -e "$work/sshd.pid" ] && kill "$(cat "$work/sshd.pid")"
    rm -rf "$work"
}
trap cleanup EXIT
cc -shared -fPIC -O1 -o "$work/nolock.so" "$root/tests/schedulers/nolock.c"
faketime=$(find /usr/lib -name 'libfaketime.so.1' | head -n 1)
[ -n "$faketime" ] || { echo 'libfaketime is missing: install faketime' >&2; exit 1; }
task="synth --object bottle_round -n 48 --seed 1 --drop 0 -q"

# machine NAME CLOCK FOLDER LIBRARY ARGUMENTS...: becomes the program on a machine of this name, whose clock is wrong by CLOCK,
# in a folder and with a library loaded before others.
machine() {
    local name=$1 clock=$2 folder=$3 library=$4
    shift 4
    echo "$name" > "$work/$name.boot"
    exec unshare --mount --uts --net --ipc --pid --fork --kill-child bash -c '
        set -e
        hostname "$0"
        mount --bind "$1" /proc/sys/kernel/random/boot_id
        mount --bind "$1" /proc/sys/kernel/hostname
        export LD_PRELOAD="$2 $3" FAKETIME="$4" FAKETIME_DONT_FAKE_MONOTONIC=1
        cd "$5"
        shift 5
        exec "$@"' "$name" "$work/$name.boot" "$library" "$faketime" "$clock" "$folder" "$program" "$@"
}

# lose_one FOLDER LIBRARY EAST WEST NORTH: three workers in FOLDER, which the machines know as EAST, WEST and NORTH. North is lost
# while it works and never comes back; another machine joins what the workers have left.
lose_one() {
    local folder=$1 library=$2
    machine east +3h "$3" "$library" $task --threads 1 --worker 1/3 -o g.parquet &
    local east=$!
    machine west -2h "$4" "$library" $task --threads 1 --worker 2/3 -o g.parquet &
    local west=$!
    machine north +0 "$5" "$library" $task --threads 1 --worker 3/3 -o g.parquet &
    local north=$!
    until [ "$(stat -c %s "$folder"/g.parquet.workers/3-of-3*.journal 2> /dev/null || echo 0)" -gt 3000 ]; do sleep 0.05; done
    kill -9 "$north"
    wait "$north" || true
    (machine south +1d "$5" "$library" status g.parquet)
    wait "$east"
    wait "$west"
    (machine south +1d "$5" "$library" $task -o g.parquet)
    cmp "$folder/g.parquet" "$work/one/g.parquet"
}

mkdir "$work/one" "$work/shared" "$work/served" "$work"/mount-{east,west,north} "$work/small"
(cd "$work/one" && "$program" $task -o g.parquet)

lose_one "$work/shared" "$work/nolock.so" "$work/shared" "$work/shared" "$work/shared"
echo 'hosts: without locks, with wrong clocks and a lost machine: the same bytes'

# A file system over the network: each machine has a mount of its own, which sees the locks of no other and what others write only
# after a while.
ssh-keygen -q -t ed25519 -N '' -f "$work/key"
ssh-keygen -q -t ed25519 -N '' -f "$work/host"
cat > "$work/sshd.conf" <<EOF
Port 2222
ListenAddress 127.0.0.1
HostKey $work/host
AuthorizedKeysFile $work/key.pub
StrictModes no
PermitRootLogin yes
PidFile $work/sshd.pid
Subsystem sftp internal-sftp
EOF
mkdir -p /run/sshd
/usr/sbin/sshd -f "$work/sshd.conf"
for name in east west north; do
    sshfs -p 2222 -o "IdentityFile=$work/key,StrictHostKeyChecking=no,UserKnownHostsFile=/dev/null,LogLevel=ERROR" \
        "root@127.0.0.1:$work/served" "$work/mount-$name"
done
lose_one "$work/served" "" "$work/mount-east" "$work/mount-west" "$work/mount-north"
echo 'hosts: over a network: the same bytes'

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
