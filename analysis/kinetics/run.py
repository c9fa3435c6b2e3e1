"""Rates of `landscape rates` beside dense matrices -> figures/kinetics.md

    cargo build --release
    python3 analysis/kinetics/run.py target/release/landscape

The matrices are solved twice, without code of this program: by numpy in numbers of 64 bits, and by Gaussian elimination in
decimal numbers of DIGITS digits, which are exact enough for any temperature here.
"""

import decimal
import json
import math
import os
import random
import subprocess
import sys
import tempfile
from decimal import Decimal

import numpy as np

OUTPUT = "figures/kinetics.md"
REFERENCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tests/reference/kinetics_32_states.json")
# Pivots may be as small as the ratio of the slowest to the fastest rate, so the digits exceed its decades twice.
DIGITS = 4000
decimal.getcontext().prec = 60
NAMES = ("first_passage", "mean_time", "steady_state", "committors")


def written(folder, minima, saddles):
    """min.data and ts.data of (energy, ln-product, order) and (…, minimum, minimum)."""
    os.makedirs(folder)
    with open(os.path.join(folder, "min.data"), "w") as file:
        file.writelines(f"{energy!r} {logs!r} {order} 1 1 1\n" for energy, logs, order in minima)
    with open(os.path.join(folder, "ts.data"), "w") as file:
        file.writelines(f"{energy!r} {logs!r} {order} {a + 1} {b + 1} 1 1 1\n" for energy, logs, order, a, b in saddles)


def read(folder):
    minima = [line.split() for line in open(os.path.join(folder, "min.data"))]
    saddles = [line.split() for line in open(os.path.join(folder, "ts.data"))]
    minima = [(Decimal(m[0]), Decimal(m[1]), int(m[2])) for m in minima]
    assert [m[0] for m in minima] == sorted(m[0] for m in minima)
    return minima, [(Decimal(s[0]), Decimal(s[1]), int(s[2]), int(s[3]) - 1, int(s[4]) - 1) for s in saddles]


def logarithms(minima, saddles, temperature):
    """ln of the rate of each ordered pair, as lists of terms, and ln of the weights."""
    t = Decimal(repr(temperature))
    weights = [-energy / t - logs / 2 - Decimal(order).ln() for energy, logs, order in minima]
    rates = {}
    for energy, logs, order, a, b in saddles:
        if a != b:
            flow = -energy / t - logs / 2 - Decimal(order).ln() - Decimal(2 * math.pi).ln()
            rates.setdefault((a, b), []).append(flow - weights[a])
            rates.setdefault((b, a), []).append(flow - weights[b])
    return rates, weights


def numpy_solution(rates, weights, sources, targets):
    n = len(weights)
    k = np.zeros((n, n))
    for (a, b), terms in rates.items():
        k[a, b] = sum(math.exp(float(term)) for term in terms)
    generator = k - np.diag(k.sum(axis=1))
    free = [i for i in range(n) if i not in targets]
    time = np.zeros(n)
    time[free] = np.linalg.solve(generator[np.ix_(free, free)], -np.ones(len(free)))
    free = [i for i in free if i not in sources]
    q = np.zeros(n)
    q[targets] = 1.0
    q[free] = np.linalg.solve(generator[np.ix_(free, free)], -k[np.ix_(free, targets)].sum(axis=1))
    top = max(weights[i] for i in sources)
    p = np.array([math.exp(float(weights[i] - top)) for i in sources])
    p /= p.sum()
    with np.errstate(all="ignore"):
        return {
            "first_passage": float(np.log(np.sum(p / time[sources]))), "mean_time": float(-np.log(np.sum(p * time[sources]))),
            "steady_state": float(np.log(np.sum(p * (k[sources] @ q)))), "committors": [float(v) for v in np.log(q)],
        }


def solved(matrix, right):
    """Gaussian elimination with the largest pivot of each column."""
    n = len(right)
    rows = [list(row) + [value] for row, value in zip(matrix, right)]
    for c in range(n):
        pivot = max(range(c, n), key=lambda r: abs(rows[r][c]))
        rows[c], rows[pivot] = rows[pivot], rows[c]
        for r in range(c + 1, n):
            if rows[r][c]:
                factor = rows[r][c] / rows[c][c]
                rows[r] = [u - factor * v if v else u for u, v in zip(rows[r], rows[c])]
    x = [Decimal(0)] * n
    for r in range(n - 1, -1, -1):
        x[r] = (rows[r][n] - sum(rows[r][c] * x[c] for c in range(r + 1, n))) / rows[r][r]
    return x


def decimal_solution(rates, weights, sources, targets, digits):
    with decimal.localcontext() as context:
        context.prec, context.Emax, context.Emin = digits, 10**9, -(10**9)
        n = len(weights)
        k = [[Decimal(0)] * n for _ in range(n)]
        for (a, b), terms in rates.items():
            k[a][b] = sum(term.exp() for term in terms)
        generator = [[k[i][j] - (sum(k[i]) if i == j else 0) for j in range(n)] for i in range(n)]
        free = [i for i in range(n) if i not in targets]
        time = dict(zip(free, solved([[generator[i][j] for j in free] for i in free], [Decimal(-1)] * len(free))))
        free = [i for i in free if i not in sources]
        q = {**{i: Decimal(0) for i in sources}, **{i: Decimal(1) for i in targets}}
        if free:
            q.update(zip(free, solved([[generator[i][j] for j in free] for i in free], [-sum(k[i][j] for j in targets) for i in free])))
        top = max(weights[i] for i in sources)
        p = {i: (weights[i] - top).exp() for i in sources}
        whole = sum(p.values())
        p = {i: value / whole for i, value in p.items()}
        # Only 30 digits of a result are needed.
        context.prec = 30
        log = lambda value: float((+value).ln()) if value > 0 else -math.inf  # noqa: E731
        return {
            "first_passage": log(sum(p[i] / time[i] for i in sources)), "mean_time": -log(sum(p[i] * time[i] for i in sources)),
            "steady_state": log(sum(p[i] * sum(k[i][j] * q[j] for j in range(n)) for i in sources)),
            "committors": [log(q[i]) for i in range(n)],
        }


def ours(binary, folder, temperature, sources, targets):
    names = [",".join(f"m{i}" for i in group) for group in (sources, targets)]
    run = subprocess.run([binary, "rates", folder, "--from", names[0], "--to", names[1], "--temperature", repr(temperature),
                          "--json", "--pathways", "1"], capture_output=True, text=True, check=True)
    at = json.loads(run.stdout)["at"][0]
    result = {name: at["forward"][f"log_{of}"] for name, of in (
        ("first_passage", "first_passage_rate"), ("mean_time", "inverse_mean_time"), ("steady_state", "steady_state_rate"))}
    # JSON has no infinity: null is the committor 0.
    result["committors"] = [-math.inf if value is None else value for value in at["log_committors"]]
    return result


def difference(mine, other):
    """The greatest relative difference of two numbers that are given by their logarithms."""
    pairs = list(zip(mine, other)) if isinstance(mine, list) else [(mine, other)]
    greatest = 0.0
    for a, b in pairs:
        if a != b:
            greatest = max(greatest, abs(math.expm1(min(a - b, 50.0))) if math.isfinite(a) and math.isfinite(b) else math.inf)
    return greatest


def shown(value):
    return "fails" if not value < 0.5 else f"{value:.1e}" if value else "0"


def row(binary, folder, name, temperature, sources, targets):
    minima, saddles = read(folder)
    rates, weights = logarithms(minima, saddles, temperature)
    logs = [max(terms) for terms in rates.values()]
    decades = float((max(logs) - min(logs)) / Decimal(10).ln())
    digits = max(60, min(DIGITS, int(2 * decades) + 80))
    mine = ours(binary, folder, temperature, sources, targets)
    exact = decimal_solution(rates, weights, sources, targets, digits)
    plain = numpy_or_none(rates, weights, sources, targets)
    cells = [name, repr(temperature), f"{decades:.0f}", f"10^{exact['first_passage'] / math.log(10):.3f}"]
    cells += [shown(difference(mine[key], exact[key])) for key in NAMES]
    cells += [shown(max(difference(plain[key], exact[key]) for key in NAMES)) if plain else "fails"]
    print(cells, flush=True)
    return "| " + " | ".join(cells) + " |\n", max(difference(mine[key], exact[key]) for key in NAMES)


def numpy_or_none(*arguments):
    try:
        return numpy_solution(*arguments)
    except (np.linalg.LinAlgError, OverflowError):
        return None


def random_network(folder, states=30, seed=1):
    """Minima between 0 and 1 that are joined in a ring and at random, over saddles up to 1 higher."""
    draw = random.Random(seed)
    minima = sorted((draw.random(), 10.0 * draw.random(), draw.choice((1, 2, 4))) for _ in range(states))
    pairs = [(k, (k + 1) % states) for k in range(states)] + [tuple(draw.sample(range(states), 2)) for _ in range(states)]
    saddles = [(max(minima[a][0], minima[b][0]) + draw.random(), 10.0 * draw.random(), 1, a, b) for a, b in pairs]
    written(folder, minima, saddles)


def main(binary):
    binary = os.path.abspath(binary)
    text = (
        "# Rates beside dense matrices\n\nMade by `analysis/kinetics/run.py`. `landscape rates` eliminates minima one by one, in "
        "logarithms. The same rate constants make a matrix, which is solved here without code of this program: in decimal "
        "numbers of enough digits for every temperature, and by numpy in numbers of 64 bits. Differences are relative, and each is the "
        "greatest of its kind: of the rate constant Σ p/T, of the mean first-passage time, of the steady-state rate, and of the "
        "committors of all minima. “Decades” are those between the slowest and the fastest rate of the network. “fails” "
        "means an error of more than a half, or a matrix that is singular to numpy.\n\n"
        "| network | kT | decades | rate | difference of the rate | of the mean time | of the steady-state rate | of the committors | numpy, "
        "greatest difference |\n|---|---|---|---|---|---|---|---|---|\n")
    worst = 0.0
    with tempfile.TemporaryDirectory() as top:
        nine = os.path.join(top, "nine")
        subprocess.run([binary, "surface", "lj", "9", "-q", "--no-report", "--seed", "1", "-o", nine], check=True)
        for temperature in (0.3, 0.1, 0.05, 0.02, 0.005, 0.002):
            for name, sources, targets in (("9 atoms, m1 to m0", [1], [0]), ("9 atoms, m5 to m9 to m0 and m1", [5, 6, 7, 8, 9], [0, 1])):
                line, difference_here = row(binary, nine, name, temperature, sources, targets)
                text, worst = text + line, max(worst, difference_here)
        ring = os.path.join(top, "random")
        random_network(ring)
        for temperature in (0.1, 0.01, 0.001, 0.0003):
            line, difference_here = row(binary, ring, "30 random minima, m20 to m29 to m0", temperature, list(range(20, 30)), [0])
            text, worst = text + line, max(worst, difference_here)
        text += (
            f"\nThe greatest difference of this program is {worst:.1e}. The logarithm of a rate of 10⁻¹⁰⁰⁰ is near −2300 and has 16 "
            "digits, so the rate is exact to about 10⁻¹² of itself at best.\n\n"
            "## A published network\n\nThe 32 states of D. Kannan, D. J. Sharpe, T. D. Swinburne and D. J. Wales, J. Chem. Phys. 153, 244108 "
            "(2020), with the values that PyGT 0.3.0 computes. `tests/kinetics.rs` compares the same numbers. PyGT works with the "
            "rates themselves and not with logarithms. Its tutorial prints the mean times 664.58268 and 585.79341 at kT = 1.\n\n"
            "| kT | quantity | decimal matrix | landscape rates | PyGT | difference of landscape | difference of PyGT |\n|---|---|---|---|---|---|---|\n")
        published = json.load(open(REFERENCE))
        order = sorted(range(len(published["minima"])), key=lambda k: published["minima"][k])
        place = {k: at for at, k in enumerate(order)}
        folder = os.path.join(top, "published")
        written(folder, [(published["minima"][k], 1.0, 1) for k in order],
                [(energy, 1.0, 1, place[a], place[b]) for energy, a, b in published["transition_states"]])
        a, b = ([place[k] for k in published[name]] for name in "ab")
        for at in published["rates"]:
            for end, sources, targets in (("to_a", b, a), ("to_b", a, b)):
                mine = ours(binary, folder, at["temperature"], sources, targets)
                rates, weights = logarithms(*read(folder), at["temperature"])
                exact = decimal_solution(rates, weights, sources, targets, 300)
                for key, title, sign in (("mean_time", "mean time", -1), ("steady_state", "steady-state rate", 1), ("first_passage", "rate", 1)):
                    theirs = at.get(f"{key}_{end}")
                    if theirs is not None:
                        right, here = (math.exp(sign * of[key]) for of in (exact, mine))
                        text += (f"| {at['temperature']:.4g} | {title} {end.replace('_', ' ')} | {right:.12g} | {here:.12g} | {theirs:.12g} | "
                                 f"{shown(abs(here / right - 1))} | {shown(abs(theirs / right - 1))} |\n")
    text += (
        "\nWhere PyGT differs, the decimal matrix agrees with this program: Σ p/T at kT = 0.1 is a sum in which PyGT loses digits.\n")
    with open(OUTPUT + ".new", "w") as file:
        file.write(text)
    os.replace(OUTPUT + ".new", OUTPUT)
    print(text)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
