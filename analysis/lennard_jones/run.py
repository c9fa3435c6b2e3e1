"""Lennard-Jones clusters of 9, 13 and 38 atoms in one table -> figures/lennard_jones.md

    cargo build --release
    python3 analysis/lennard_jones/run.py target/release/landscape FOLDER [LANDSCAPE_OF_13_ATOMS ...]

Runs `landscape surface lj 9` from SEEDS seeds and `landscape surface lj 13 --budget 5m` in FOLDER, on one thread, and goes on
where it was stopped. Further landscapes of 13 atoms, of longer runs, can be named. Each point of all of them is judged by
numpy (stationary.py), and the rows of 38 atoms are those of figures/double_funnel.md, whose runs take hours.
"""

import collections
import json
import os
import re
import subprocess
import sys

import stationary

OUTPUT = "figures/lennard_jones.md"
SEEDS = 20
# J. P. K. Doye and D. J. Wales, J. Chem. Phys. 116, 3777 (2002).
PUBLISHED = {9: (21, 165), 13: (1510, 28756)}


def made(binary, folder, atoms, seed, arguments):
    out = os.path.join(folder, f"lj-{atoms}-seed-{seed}.landscape")
    if not os.path.exists(out):
        subprocess.run([binary, "surface", "lj", str(atoms), "--seed", str(seed), "--threads", "1", "-q", "--no-report", *arguments,
                        "-o", out], check=True)
    return out


def told(landscape, atoms):
    manifest = json.load(open(os.path.join(landscape, "landscape.json"), encoding="utf-8"))
    timings = json.load(open(os.path.join(landscape, "timings.json"), encoding="utf-8"))
    minima, saddles, _ = stationary.read(landscape, 3 * atoms)
    points = [stationary.judged(coordinates, index) for index, coordinates in ((0, minima), (1, saddles))]
    coverage = manifest["findings"]["coverage"]
    return {
        "minima": len(minima), "saddles": len(saddles), "right": [len(p["kept"]) for p in points],
        "false": sum(p["false"] for p in points), "twice": sum(p["twice"] for p in points),
        "alike": stationary.coinciding(points[1]["kept"])[1],
        "lowest": points[0]["kept"][0]["energy"],
        "evaluations": manifest["counts"]["evaluations"], "searches": coverage["searches"],
        "missing": (coverage["unseen"], coverage["unseen_below"]),
        "seconds": sum(phase["seconds"] for phase in timings["phases"]), "threads": timings["threads"],
        "command": re.sub(r" -o \S+| --threads \d+| --no-report| -q", "", manifest["command"]),
    }


def cells(values):
    return "| " + " | ".join(str(value) for value in values) + " |\n"


def main(binary, folder, *longer):
    os.makedirs(folder, exist_ok=True)
    binary = os.path.abspath(binary)
    nine = [told(made(binary, folder, 9, seed, []), 9) for seed in range(SEEDS)]
    thirteen = [told(made(binary, folder, 13, 0, ["--budget", "5m"]), 13)] + [told(other, 13) for other in longer]
    text = (
        "# Lennard-Jones clusters of 9, 13 and 38 atoms\n\nMade by `analysis/lennard_jones/run.py`. The published numbers are those of J. P. K. Doye and D. J. "
        "Wales, J. Chem. Phys. 116, 3777 (2002), and no run knows them. Seconds are those of the clock while other work ran on "
        "the machine. The rows of 38 atoms are those of [double_funnel.md](double_funnel.md); that landscape is too large to "
        "enumerate, so its runs search its lowest part only. "
        "The runs of 13 atoms with budgets of 25 and 105 million are of the program before searches began where the rarest "
        "saddles are met most often for an evaluation.\n\n"
        "| atoms | run | minima | published minima | saddles | published saddles | million evaluations | seconds | threads |\n"
        "|---|---|---|---|---|---|---|---|---|\n")
    counts = collections.Counter((run["minima"], run["saddles"]) for run in nine)
    mean = lambda name: sum(run[name] for run in nine) / len(nine)  # noqa: E731
    for (minima, saddles), seeds in sorted(counts.items(), reverse=True):
        text += cells([9, f"{seeds} of {SEEDS} seeds", minima, PUBLISHED[9][0], saddles, PUBLISHED[9][1],
                       f"{mean('evaluations') / 1e6:.2f} on average", f"{mean('seconds'):.0f} on average", 1])
    for run in thirteen:
        text += cells([13, f"`{run['command']}`", run["minima"], PUBLISHED[13][0], run["saddles"], PUBLISHED[13][1],
                       f"{run['evaluations'] / 1e6:.1f}", f"{run['seconds']:.0f}", run["threads"]])
    for line in open("figures/double_funnel.md", encoding="utf-8"):
        if line.startswith("| seed "):
            row = [cell.strip() for cell in line.strip().strip("|").split("|")]
            text += cells([38, row[0], row[6], "", row[8], "", row[9], row[10], row[11]])
    text += (
        "\n## Are the points right, and is each counted once?\n\nEvery point of these runs of 9 and 13 atoms was judged by numpy, without code of this "
        "program: Newton’s method ends beside the point at a gradient below 10⁻⁸, with no negative curvature for a minimum and "
        "one for a saddle. Two points are one if their energies agree to 10⁻⁶, the sums of the logarithms of their curvatures "
        "to 10⁻³ and their moments of inertia to 10⁻⁴ of the largest. A pair of saddles that agree in the energy alone is not a "
        "pair of copies.\n\n"
        "| run | right minima | right saddles | points that are not stationary or have another index | copies of another point | pairs of "
        "saddles with one energy only |\n|---|---|---|---|---|---|\n")
    total = lambda name: sum(run[name] for run in nine)  # noqa: E731
    text += cells([f"9 atoms, all {SEEDS} seeds", sum(run["right"][0] for run in nine), sum(run["right"][1] for run in nine),
                   total("false"), total("twice"), total("alike")])
    for run in thirteen:
        text += cells([f"13 atoms, `{run['command']}`", *run["right"], run["false"], run["twice"], run["alike"]])
    text += (
        "\n## What the runs say of themselves\n\nA run that is stopped claims no completeness. It estimates how many saddles are missing from how often each "
        "was met: at least (Chao’s estimate) and at most (a limit of 95 %).\n\n"
        "| run | searches | missing saddles, at least | missing saddles, at most | published saddles minus found ones |\n|---|---|---|---|---|\n")
    for run in thirteen:
        text += cells([f"13 atoms, `{run['command']}`", run["searches"], *(("not told", "not told") if run["missing"][1] is None else (round(run["missing"][0]), run["missing"][1])),
                       PUBLISHED[13][1] - run["saddles"]])
    limits = sorted(run["missing"][1] for run in nine)
    text += (f"\nA run that has too few searches along modes tells no number. The {SEEDS} runs of 9 atoms ended by themselves. They say that "
             f"at most {limits[0]} to {limits[-1]} saddles are missing, and none is.\n" if all(
                 (run["minima"], run["saddles"]) == PUBLISHED[9] for run in nine) else "\n")
    if any(run["saddles"] > PUBLISHED[13][1] for run in thirteen):
        text += ("\nA negative number in the last column means more saddles than the literature lists. All of them are right by the table "
                 "above, and none is a copy of another.\n")
    with open(OUTPUT + ".new", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(OUTPUT + ".new", OUTPUT)
    print(text)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
