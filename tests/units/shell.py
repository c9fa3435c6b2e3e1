"""The reference surfaces in other units: shell.py MODEL LENGTH ENERGY, for `landscape surface --command`."""

import json
import math
import sys

model, length, energy_unit = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
# Angles and quaternions are no lengths.
stretch = 1.0 if model in ("torsion", "orientation") else length


def gaussians(x, y, terms):
    energy, slope = 0.0, [0.0, 0.0]
    for height, a, b, c, x0, y0 in terms:
        dx, dy = x - x0, y - y0
        value = height * math.exp(a * dx * dx + b * dx * dy + c * dy * dy)
        energy += value
        slope[0] += value * (2.0 * a * dx + b * dy)
        slope[1] += value * (b * dx + 2.0 * c * dy)
    return energy, slope


def muller_brown(p):
    return gaussians(*p, (
        (-200.0, -1.0, 0.0, -10.0, 1.0, 0.0),
        (-100.0, -1.0, 0.0, -10.0, 0.0, 0.5),
        (-170.0, -6.5, 11.0, -6.5, -0.5, 1.5),
        (15.0, 0.7, 0.6, 0.7, -1.0, 1.0),
    ))


def three_hole(p):
    x, y = p[0], p[1] - 1.0 / 3.0
    energy, slope = gaussians(*p, (
        (3.0, -1.0, 0.0, -1.0, 0.0, 1.0 / 3.0),
        (-3.0, -1.0, 0.0, -1.0, 0.0, 5.0 / 3.0),
        (-5.0, -1.0, 0.0, -1.0, 1.0, 0.0),
        (-5.0, -1.0, 0.0, -1.0, -1.0, 0.0),
    ))
    return energy + 0.2 * (x**4 + y**4), [slope[0] + 0.8 * x**3, slope[1] + 0.8 * y**3]


def double_well(p):
    energy = sum((x * x - 1.0) ** 2 + 0.5 * x for x in p)
    return energy, [4.0 * x * (x * x - 1.0) + 0.5 for x in p]


def torsion(p):
    terms = list(zip((1.0, 0.5), (3.0, 2.0), p))
    return sum(h * (1.0 - math.cos(k * x)) for h, k, x in terms), [h * k * math.sin(k * x) for h, k, x in terms]


def orientation(p):
    size = math.sqrt(sum(q * q for q in p))
    w, i, j, k = (q / size for q in p)
    weights = (1.0, 1.5, 2.0, 3.0)
    slope = [-4.0 * c * q**3 for c, q in zip(weights, (w, i, j, k))]
    turns = ((-i, w, k, -j), (-j, -k, w, i), (-k, j, -i, w))
    energy = -sum(c * q**4 for c, q in zip(weights, (w, i, j, k)))
    return energy, [0.5 * sum(s * t for s, t in zip(slope, turn)) for turn in turns]


def lj(p):
    energy, slope = 0.0, [0.0] * len(p)
    for i in range(0, len(p), 3):
        for j in range(0, i, 3):
            apart = [p[i + k] - p[j + k] for k in range(3)]
            square = sum(d * d for d in apart)
            sixth = 1.0 / square**3
            energy += 4.0 * sixth * (sixth - 1.0)
            factor = 24.0 * sixth * (1.0 - 2.0 * sixth) / square
            for k in range(3):
                slope[i + k] += factor * apart[k]
                slope[j + k] -= factor * apart[k]
    return energy, slope


surface = {
    "muller-brown": muller_brown,
    "three-hole": three_hole,
    "double-well": double_well,
    "torsion": torsion,
    "orientation": orientation,
    "lj": lj,
}[model]
for line in sys.stdin:
    try:
        energy, gradient = surface([x / stretch for x in json.loads(line)["x"]])
        per_length = energy_unit / stretch
        answer = {"energy": energy_unit * energy, "gradient": [per_length * g for g in gradient]}
        if not all(map(math.isfinite, [answer["energy"], *answer["gradient"]])):
            answer = {"energy": None}
    except (OverflowError, ZeroDivisionError):
        answer = {"energy": None}
    print(json.dumps(answer), flush=True)
