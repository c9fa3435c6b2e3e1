#!/bin/bash
# Runs docs/cluster/slurm.sh against the daemons of Slurm on this machine, and compares the bytes with those of one process.
#
#   cargo build --release && sudo bash tests/schedulers/slurm.sh
#
# Needs root and the packages slurm-wlm and munge of Debian or Ubuntu, and no running Slurm. All files are in a temporary
# folder; the daemons end with the script.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
export LANDSCAPE=${LANDSCAPE:-$root/target/release/landscape}
work=$(mktemp -d)
chmod 755 "$work"
export SLURM_CONF=$work/slurm.conf
host=$(hostname -s)

mkdir -p "$work/state" "$work/spool" /run/munge
chown munge: /run/munge
dd if=/dev/urandom of="$work/munge.key" bs=1 count=1024 status=none
chown munge: "$work" "$work/munge.key"
chmod 400 "$work/munge.key"
cat > "$SLURM_CONF" <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
SlurmUser=root
SlurmdUser=root
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
SlurmctldPort=16817
SlurmdPort=16818
ReturnToService=2
SchedulerParameters=sched_interval=1,sched_min_interval=0
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
stop() {
    for daemon in slurmd slurmctld munged; do
        [ ! -f "$work/$daemon.pid" ] || kill "$(cat "$work/$daemon.pid")" 2> /dev/null || true
    done
    sleep 1
    rm -rf "$work"
}
trap stop EXIT
setpriv --reuid=munge --regid=munge --clear-groups munged --key-file="$work/munge.key" --socket="$work/munge.socket" \
    --pid-file="$work/munged.pid" --log-file="$work/munged.log" --seed-file="$work/munged.seed"
slurmctld
slurmd
for _ in $(seq 50); do
    sinfo -h -o %T 2> /dev/null | grep -q idle && break
    sleep 0.2
done

mkdir "$work/desk"
cd "$work/desk"
run() { # NAME WORKERS COMMAND...: as the page says, then waits
    started=$(date +%s)
    shift
    CPUS=1 TIME=10:00 bash "$root/docs/cluster/slurm.sh" "$@"
    while [ -n "$(squeue -h)" ]; do sleep 0.5; done
    echo "slurm: $* took $(($(date +%s) - started)) s"
    cat landscape-join.log
}
run synth 8 synth --object ball -n 16 --seed 1 -o g.parquet
run build 5 build g.parquet --first 8
ls landscape-worker-*.log | wc -l
mkdir one
mv g.parquet g.landscape one
"$LANDSCAPE" synth --object ball -n 16 --seed 1 -o g.parquet -q
"$LANDSCAPE" build g.parquet --first 8 -q
# The recorded commands are equal but for the number of threads, which is none of the result.
"$LANDSCAPE" inspect g.parquet --json > one.json
"$LANDSCAPE" inspect one/g.parquet --json | diff - one.json
diff -rq -x timings.json g.landscape one/g.landscape
cmp g.parquet one/g.parquet
ls
echo "slurm: the same bytes as one process"
