"""Stationary points of Lennard-Jones clusters, judged by numpy alone: no code of the programs that found them is used."""

import numpy as np

# Six modes of a cluster cost nothing: it can be moved and turned.
FREE = 6
# A point is stationary if its gradient is at most this after Newton's method, which moves it by at most MOVED.
SLOPE = 1e-8
MOVED = 0.05
# Two points are one if all of these agree: the energy, the sum of the logarithms of the curvatures, and the moments of inertia
# (relative to the largest). None of them changes if a cluster is moved, turned, mirrored or renumbered.
SAME_ENERGY = 1e-6
SAME_LOGS = 1e-3
SAME_MOMENTS = 1e-4


def value_slope_and_curvature(x):
    """Energy, gradient and Hessian of 4 (r⁻¹² − r⁻⁶), summed over pairs."""
    p = x.reshape(-1, 3)
    n = len(p)
    d = p[:, None, :] - p[None, :, :]
    square = np.einsum("ijk,ijk->ij", d, d) + np.eye(n)
    six = square**-3
    np.fill_diagonal(six, 0.0)
    value = 2.0 * np.sum(six * six - six)
    # V′/r and V″ − V′/r over r².
    first = 4.0 * (-12.0 * six * six + 6.0 * six) / square
    second = 4.0 * (168.0 * six * six - 48.0 * six) / square**2
    slope = np.einsum("ij,ijk->ik", first, d).ravel()
    blocks = -(second[:, :, None, None] * d[:, :, :, None] * d[:, :, None, :] + first[:, :, None, None] * np.eye(3))
    for i in range(n):
        blocks[i, i] = -blocks[i].sum(axis=0) + blocks[i, i]
    return value, slope, blocks.transpose(0, 2, 1, 3).reshape(3 * n, 3 * n)


def polished(x, steps=30):
    """The stationary point at which Newton's method ends, and whether it has stayed near its start."""
    start = np.array(x, float)
    x = start.copy()
    for _ in range(steps):
        value, slope, curvature = value_slope_and_curvature(x)
        if not np.isfinite(value) or np.abs(slope).max() < 1e-12:
            break
        values, modes = np.linalg.eigh(curvature)
        kept = np.argsort(np.abs(values))[FREE:]
        step = -modes[:, kept] @ ((modes[:, kept].T @ slope) / values[kept])
        if not np.all(np.isfinite(step)) or np.abs(step).max() > 0.3:
            break
        x = x + step
        if np.abs(step).max() < 1e-13:
            break
    return x, np.abs(x - start).max() <= MOVED


def described(x):
    """What does not change if the cluster is moved, turned, mirrored or renumbered; the index; and the steepest slope left."""
    value, slope, curvature = value_slope_and_curvature(x)
    values = np.linalg.eigvalsh(curvature)
    values = values[np.sort(np.argsort(np.abs(values))[FREE:])]
    p = x.reshape(-1, 3) - x.reshape(-1, 3).mean(axis=0)
    moments = np.linalg.eigvalsh(np.sum(p * p) * np.eye(3) - p.T @ p)
    return {
        "energy": float(value),
        "logs": float(np.log(np.abs(values)).sum()),
        "moments": [float(m) for m in moments],
        "index": int(np.sum(values < 0)),
        "slope": float(np.abs(slope).max()),
    }


def same(a, b):
    return (
        abs(a["energy"] - b["energy"]) <= SAME_ENERGY
        and abs(a["logs"] - b["logs"]) <= SAME_LOGS
        and max(abs(p - q) for p, q in zip(a["moments"], b["moments"])) <= SAME_MOMENTS * max(a["moments"])
    )


def coinciding(points):
    """Pairs of points that are one, and pairs that have one energy only."""
    order = sorted(range(len(points)), key=lambda k: points[k]["energy"])
    pairs, alike = [], 0
    for at, i in enumerate(order):
        for j in order[at + 1:]:
            if points[j]["energy"] - points[i]["energy"] > SAME_ENERGY:
                break
            if same(points[i], points[j]):
                pairs.append((i, j))
            else:
                alike += 1
    return pairs, alike


def judged(coordinates, index):
    """Which of the points of a program are stationary with this index, each once; and the numbers of those that are not, or
    that are there twice. `number[k]` is the place of point k among the kept ones, or none."""
    points, kept, false, twice = [], [], 0, 0
    for x in coordinates:
        x = np.array(x, float)
        better, near = polished(x)
        point = described(better) if near else None
        right = point is not None and point["slope"] < SLOPE and point["index"] == index
        points.append(point if right else None)
        false += not right
    order = sorted((k for k, p in enumerate(points) if p), key=lambda k: points[k]["energy"])
    number = [None] * len(points)
    for k in order:
        # Equal points have equal energies, so only the last few can be the same.
        found = None
        for at in range(len(kept) - 1, -1, -1):
            if points[k]["energy"] - kept[at]["energy"] > SAME_ENERGY:
                break
            if same(points[k], kept[at]):
                found = at
                break
        if found is None:
            found = len(kept)
            kept.append(points[k])
        else:
            twice += 1
        number[k] = found
    return {"kept": kept, "number": number, "false": false, "twice": twice}


def highest_on_the_way(count, saddles, start, end):
    """The lowest energy at which two minima are connected. `saddles`: energy and the two minima of each."""
    parent = list(range(count))

    def root(k):
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    for energy, a, b in sorted(saddles):
        parent[root(a)] = root(b)
        if root(start) == root(end):
            return energy
    return None


def read(folder, coordinates):
    """Points of a landscape folder, and between which minima each saddle is."""
    minima = np.fromfile(f"{folder}/points.min").reshape(-1, coordinates)
    saddles = np.fromfile(f"{folder}/points.ts").reshape(-1, coordinates)
    rows = [line.split() for line in open(f"{folder}/ts.data", encoding="utf-8")]
    return minima, saddles, [(int(row[3]) - 1, int(row[4]) - 1) for row in rows]
