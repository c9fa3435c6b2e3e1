#!/bin/bash
# Compares the bytes that processors with different vector instructions make, by emulation (qemu-user 7.2 or later).
#
#   cargo build --release && bash tests/schedulers/processors.sh
#
# Takes about an hour of CPU: emulation is some thirty times slower. The kinds are Nehalem (neither AVX nor FMA), Haswell (AVX2
# and FMA) and this machine, once with the variants of glibc for old processors. With OTHER=PROGRAM, another build of the same
# commit is compared too (the static program, whose C library is musl).
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
program=${LANDSCAPE:-$root/target/release/landscape}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
results() { # KIND COMMAND...: hashes of all results
    kind=$1
    shift
    mkdir "$work/$kind"
    cd "$work/$kind"
    "$@" "$program" synth --object mug -n 4 --seed 3 --keep all --drop 0 -q --threads 1 -o m.parquet
    "$@" "$program" build m.parquet -q --threads 1 --no-report
    "$@" "$program" stability m.parquet -q --threads 1
    "$@" "$program" surface lj 7 -q --threads 1 --no-report
    find . -type f ! -name timings.json -exec sha256sum {} + | sort -k2 > "$work/$kind.sums"
    cd "$work"
}
kinds="glibc Nehalem Haswell"
results native env
results glibc env GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4,-AVX512F
for kind in Nehalem Haswell; do
    results $kind qemu-x86_64 -cpu $kind 2> "$work/qemu.log" || { cat "$work/qemu.log"; exit 1; }
done
if [ -n "${OTHER:-}" ]; then
    kinds="$kinds other"
    program=$OTHER results other env
fi
same=0
for kind in $kinds; do
    if diff "$work/native.sums" "$work/$kind.sums"; then
        echo "$kind: the same bytes as this machine"
    else
        echo "$kind: other bytes than this machine"
        same=1
    fi
done
exit $same
