"""Energies and gradients of a batch of grasps from Python beside those of Rust: `cargo bench --bench grasp -- batch`.

python python/benches/batch.py [ROUNDS]    prints microseconds per grasp in turns, and the ratio of the medians
"""

import json
import statistics
import subprocess
import sys
import time
from pathlib import Path

import landscape as ls

ROOT = Path(__file__).parents[2]
rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 2
grasps = ls.Grasps.read(ROOT / "data/grasps.parquet")
energy = ls.Energy(ls.Hand("human"), ls.Object("bottle_round"))
# The features are those of the package, so that nothing is built twice.
bench = ["cargo", "bench", "--workspace", "--bench", "grasp"]
subprocess.run([*bench, "--no-run"], cwd=ROOT, check=True)
found = energy.evaluate(grasps)[0]
assert abs(found - grasps.energy).max() < 1e-9, "the same energies as in the file"


def of_python():
    """Median over 5 s, microseconds per grasp."""
    times, end = [], time.perf_counter() + 5
    while time.perf_counter() < end:
        started = time.perf_counter()
        energy.evaluate(grasps)
        times.append(time.perf_counter() - started)
    return 1e6 * statistics.median(times) / len(grasps)


def of_rust():
    """The median that the bench tells, microseconds per grasp."""
    done = subprocess.run([*bench, "--", "batch"], cwd=ROOT, check=True, capture_output=True, text=True)
    assert "grasp/batch" in done.stdout, done.stdout
    place = json.loads(subprocess.run(
        ["cargo", "metadata", "--no-deps", "--format-version=1"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout)["target_directory"]
    told = json.loads((Path(place) / "criterion/grasp_batch/all cores/new/estimates.json").read_text())
    return 1e-3 * told["median"]["point_estimate"] / len(grasps)


pairs = [(of_python(), of_rust()) for _ in range(rounds)]
for python, rust in pairs:
    print(f"Python {python:.2f} µs, Rust {rust:.2f} µs a grasp")
python, rust = (statistics.median(each) for each in zip(*pairs))
print(f"ratio {python / rust:.3f}")
