#!/bin/bash
# Runs a landscape command on many nodes of a Slurm cluster, and joins the journals of its workers at the end.
#
#   bash slurm.sh 64 build grasps.parquet
#   CPUS=8 TIME=12:00:00 bash slurm.sh 64 synth --object mug.obj -n 100000 -o mug.parquet
#
# The first word is the number of workers; the others are the command. All nodes must see the working folder. A worker that
# is killed, requeued or not started yet costs nothing but time: the others take over its tasks. SBATCH_PARTITION,
# SBATCH_ACCOUNT and other variables of sbatch apply.
set -eu
workers=$1
shift
cpus=${CPUS:-4}
command="${LANDSCAPE:-landscape}$(printf ' %q' "$@") --threads $cpus"

array=$(sbatch --parsable --job-name=landscape --array=1-"$workers" --cpus-per-task="$cpus" --time="${TIME:-04:00:00}" \
    --requeue --open-mode=append --output=landscape-worker-%a.log --wrap "exec $command --worker auto")
# The join also does what all workers left undone, so it runs even if some have failed.
sbatch --parsable --job-name=landscape-join --dependency=afterany:"$array" --cpus-per-task="$cpus" \
    --time="${TIME:-04:00:00}" --requeue --open-mode=append --output=landscape-join.log --wrap "exec $command"
