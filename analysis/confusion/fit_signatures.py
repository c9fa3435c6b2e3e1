"""Fits the signatures of the grasp types to fixtures: reads data/taxonomy/signatures_written.toml, writes signatures.toml.

usage: cargo run --release --example confusion -- --rule data/taxonomy/signatures_written.toml --fixtures development \
           --fixtures held_out --seed 1 --copies 20 --features target/features.jsonl
       python analysis/confusion/fit_signatures.py target/features.jsonl [--check]

This script needs numpy and scipy (numpy==2.4.6, scipy==1.17.1). It starts from the written targets and weights and maximises
the likelihood of the true types of the fixtures, with p(type) ~ exp(score / TAU). Deviations from the written values cost
RIDGE times their square. The fit may add cues, except for contacts of digits, which the table of types determines. --check
runs a cross-validation instead and writes nothing: it leaves out one variant of each type in turn, fits to the others, and
prints how often the left-out variants are classified correctly.
"""

import argparse
import json
import math
import pathlib
import re
import tomllib

import numpy
from scipy.optimize import minimize

ROOT = pathlib.Path(__file__).parents[2]
TAXONOMY = ROOT / "data/taxonomy"
TAU = 0.02
RIDGE = 0.003
# Weight of the likelihood of the category, relative to that of the type.
CATEGORY = 0.5
# Fixtures of no type should score less than SCORE, and those of a type more; LISTED is the weight of the latter condition.
SCORE = 0.82
LISTED = 0.3
ITERATIONS = 80
# An added cue with a smaller weight is dropped.
LEAST = 0.15
# Bounds of weights: cues that are not key features stay below the weight of key features, and key features stay above it.
BELOW_KEY, HIGHEST = 1.45, 4.0
# This threshold was chosen with --check, so that few fixtures of no type are accepted.
UNLISTED_BELOW = 0.78
# The following two constants are those of classifier.rs.
SIZE_FACTOR = 1.8
FORMS = ["sphere", "rod", "disk", "plate"]
DIGITS = ["thumb", "index", "middle", "ring", "little"]

source = (ROOT / "src/evaluation/taxonomy/features.rs").read_text()
listed = source[source.index("const FEATURES") :]
FEATURES = re.findall(r'\(\s*"([^"]+)",\s*"[^"]+",?\s*\)', listed[: listed.index("\n];")])
NOT_ADDED = {*DIGITS, "digits", "ring of thumb and index"}
types = tomllib.loads((TAXONOMY / "feix.toml").read_text())["type"]
written = tomllib.loads((TAXONOMY / "signatures_written.toml").read_text())
CATEGORIES = numpy.array([sorted({t["category"] for t in types}).index(t["category"]) for t in types])
CELLS = numpy.array([sorted({t["cell"] for t in types}).index(t["cell"]) for t in types])


def cues_of(entry):
    """Returns the target and the weight of each cue of a type, as signature.rs composes them."""
    base, cues = written["base"], {}
    used = {digit for finger in ("vf1", "vf2", "vf3") for digit in entry[finger]}
    for digit, name in enumerate(DIGITS, 1):
        if not (digit == 1 and digit not in used and entry["opposition"] == "palm"):
            cues[name] = (float(digit in used), base["digit"])
    for kind in ("palm", "pad", "side"):
        own = kind == entry["opposition"]
        cues[f"{kind} opposition"] = (float(own), base["opposition" if own else "other_opposition"])
    cues["thumb abducted"] = (float(entry["thumb"] == "abducted"), base["thumb"])
    if entry.get("object"):
        cues["form"] = (1.0, base["form"])
    if "size_mm" in entry:
        cues["size"] = (1.0, base["size"])
    cues.update(written["category"].get(entry["category"], {}))
    (own,) = [t for t in written["type"] if t["number"] == entry["number"]]
    cues.update(own["cues"])
    return cues


TARGET, WEIGHT = numpy.zeros((2, len(types), len(FEATURES)))
for row, entry in enumerate(types):
    for name, (target, weight) in cues_of(entry).items():
        TARGET[row, FEATURES.index(name)], WEIGHT[row, FEATURES.index(name)] = target, weight
STATED = WEIGHT > 0
KEY = (WEIGHT >= written["key_weight"]) & ((TARGET <= 0) | (TARGET >= 1))
GATE = written["gate"]


class Grasps:
    """The measured features of some grasps, for each type, since form and size depend on it. NaN means not measurable."""

    def __init__(self, lines):
        self.ids = numpy.array([line["id"] for line in lines])
        self.number = numpy.array([line["type"] or 0 for line in lines])
        values = numpy.full((len(lines), len(types), len(FEATURES)), numpy.nan)
        for row, line in enumerate(lines):
            for name, value in line["features"].items():
                values[row, :, FEATURES.index(name)] = value
            if line["forms"] is None:
                continue
            for column, entry in enumerate(types):
                forms = sum(line["forms"][FORMS.index(form)] for form in entry.get("object", []))
                values[row, column, FEATURES.index("form")] = min(1.0, forms)
                if "size_mm" in entry:
                    (low, high), size = entry["size_mm"], 1e3 * line["width_m"]
                    miss = math.log(max(low / size, size / high, 1.0)) / math.log(SIZE_FACTOR)
                    values[row, column, FEATURES.index("size")] = 1.0 - min(miss, 1.0)
        self.known = ~numpy.isnan(values)
        self.values = numpy.where(self.known, values, 0.0)

    def part(self, chosen):
        part = object.__new__(Grasps)
        part.ids, part.number = self.ids[chosen], self.number[chosen]
        part.values, part.known = self.values[chosen], self.known[chosen]
        return part

    def scores(self, target, weight):
        miss = numpy.abs(self.values - target) * self.known
        total, missed = (weight * self.known).sum(2), (weight * miss).sum(2)
        gates = numpy.prod(numpy.where(KEY & self.known, 1.0 - GATE * miss, 1.0), 2)
        return miss, total, missed, gates, (1.0 - missed / total) * gates


def start(grasps):
    """Returns the first targets and the cues that may change. Cues that may be added have the mean measured value as target."""
    target, free = TARGET.copy(), STATED.copy()
    for row in range(len(types)):
        own = grasps.number == row + 1
        for column, name in enumerate(FEATURES):
            values = grasps.values[own, row, column][grasps.known[own, row, column]]
            if not STATED[row, column] and name not in NOT_ADDED and len(values):
                target[row, column], free[row, column] = values.mean(), True
    return target, free


def fit(grasps):
    """Returns the fitted targets and weights of all cues."""
    first, free = start(grasps)
    moving = free & ~KEY
    count = moving.sum()
    listed = grasps.number > 0
    truth = grasps.number[listed] - 1
    # All types have the same total weight; the fixtures of no type together weigh as much as all types.
    share = numpy.zeros(len(grasps.number))
    for number in numpy.unique(grasps.number):
        own = grasps.number == number
        share[own] = 1.0 / own.sum() / (len(types) if number else 1)

    def unpack(parameters):
        target, weight = first.copy(), WEIGHT.copy()
        target[moving], weight[free] = parameters[:count], parameters[count:]
        return target, weight

    def loss(parameters):
        target, weight = unpack(parameters)
        miss, total, missed, gates, scores = grasps.scores(target, weight)
        slope = numpy.zeros_like(scores)
        exponents = scores[listed] / TAU
        likely = numpy.exp(exponents - exponents.max(1, keepdims=True))
        likely /= likely.sum(1, keepdims=True)
        true = numpy.arange(len(types)) == truth[:, None]
        kin = CATEGORIES == CATEGORIES[truth][:, None]
        of_type, of_category = (likely * true).sum(1), (likely * kin).sum(1)
        value = -(share[listed] * (numpy.log(of_type + 1e-12) + CATEGORY * numpy.log(of_category + 1e-12))).sum()
        pull = likely - true + CATEGORY * (likely - likely * kin / (of_category[:, None] + 1e-12))
        slope[listed] += pull * share[listed][:, None] / TAU
        best = scores.argmax(1)
        for chosen, sign, factor in ((~listed, 1.0, 1.0), (listed, -1.0, LISTED)):
            rows = numpy.flatnonzero(chosen)
            over = sign * (scores[rows, best[rows]] - SCORE) / TAU
            value += (factor * share[rows] * numpy.logaddexp(0.0, over)).sum()
            slope[rows, best[rows]] += factor * share[rows] * sign / TAU / (1.0 + numpy.exp(-over))
        scaled = slope * gates / total
        by_weight = -(scaled[:, :, None] * (miss - (missed / total)[:, :, None] * grasps.known)).sum(0)
        by_target = -(scaled[:, :, None] * numpy.sign(target - grasps.values) * grasps.known).sum(0) * weight
        value += RIDGE * (((weight - WEIGHT)[free] ** 2).sum() + ((target - first)[moving] ** 2).sum())
        by_target += 2.0 * RIDGE * (target - first)
        by_weight += 2.0 * RIDGE * (weight - WEIGHT)
        return value, numpy.concatenate([by_target[moving], by_weight[free]])

    bounds = [(0.0, 1.0)] * count
    bounds += [(written["key_weight"], HIGHEST) if key else (0.0, BELOW_KEY) for key in KEY[free]]
    begin = numpy.concatenate([first[moving], WEIGHT[free]])
    begin = numpy.clip(begin, *zip(*bounds))
    found = minimize(loss, begin, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": ITERATIONS})
    target, weight = unpack(found.x)
    weight[~STATED & (weight < LEAST)] = 0.0
    return numpy.round(target, 2), numpy.round(weight, 2)


def right(grasps, target, weight):
    """Returns five shares: of grasps of a type, those with the right category, cell and type, and those that are accepted; of
    fixtures of no type, those that are accepted."""
    scores = grasps.scores(target, weight)[-1]
    best, high = scores.argmax(1), scores.max(1) >= UNLISTED_BELOW
    listed = grasps.number > 0
    truth = grasps.number[listed] - 1
    shares = [(names[best[listed]] == names[truth]).mean() for names in (CATEGORIES, CELLS, numpy.arange(len(types)))]
    return [*shares, high[listed].mean(), high[~listed].mean()]


def check(grasps):
    # The variants a to d of each type, and every fourth of the fixtures of no type.
    variant = numpy.array([ord(i[-1]) - ord("a") if "none" not in i else int(i.split("-")[1]) % 4 for i in grasps.ids])
    shares = []
    for left_out in range(4):
        target, weight = fit(grasps.part(variant != left_out))
        shares.append(right(grasps.part(variant == left_out), target, weight))
    words = ["category", "cell", "type", "listed", "others listed"]
    for word, fitted, before in zip(words, numpy.mean(shares, 0), right(grasps, TARGET, WEIGHT)):
        print(f"{word:14} {fitted:.3f} (as written, on all: {before:.3f})")


def text(target, weight):
    lines = [
        "# What tells the 33 types apart, for src/grasp/taxonomy: data/taxonomy/signatures_written.toml, adjusted to the fixtures of",
        "# tests/taxonomy/fixtures (development and held_out) by analysis/confusion/fit_signatures.py. Written by that program.",
        "#",
        "# A type's score is (1 - sum w|x - t| / sum w) times, for every key feature (weight at least `key_weight`, target 0 or 1),",
        "# (1 - gate |x - t|). x: the feature as measured, 0 to 1; a feature that cannot be measured is left out. [t, w] = target, weight.",
        "#",
        "# Every cue of a type stands here: what the table of types says (`base`, in the written file) is among them.",
        "",
        f"unlisted_below = {UNLISTED_BELOW}",
        f'ambiguous_within = {written["ambiguous_within"]}',
        f"gate = {GATE}",
        f'key_weight = {written["key_weight"]}',
        "",
        "[base]",
        *(f"{name} = 0.0" for name in written["base"]),
        "",
        "[category]",
    ]
    for entry, targets, weights in zip(types, target, weight):
        lines += ["", f'[[type]] # {entry["name"]}', f'number = {entry["number"]}', "[type.cues]"]
        for name, value, counts in zip(FEATURES, targets, weights):
            if counts > 0.0:
                lines.append(f'"{name}" = [{value:g}, {counts:g}]')
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("features", type=pathlib.Path)
    parser.add_argument("--check", action="store_true", help="run a cross-validation and write nothing")
    arguments = parser.parse_args()
    grasps = Grasps([json.loads(line) for line in arguments.features.read_text().splitlines()])
    # The rule does not classify grasps in which fewer than two parts of the hand touch the object; they have no features.
    grasps = grasps.part(grasps.known.sum((1, 2)) > 0)
    if arguments.check:
        check(grasps)
    else:
        (TAXONOMY / "signatures.toml").write_text(text(*fit(grasps)))


if __name__ == "__main__":
    main()
