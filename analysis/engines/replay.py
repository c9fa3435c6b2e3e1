"""How often Rapier and MuJoCo agree on driven ways, printed for figures/replayed_ways.md.

    python analysis/engines/replay.py FOLDER --table figures/replayed_ways.csv --ways 50

needs the Python package and `pip install mujoco`. FOLDER is that of `--example replayed_ways`; for each of its landscapes it
must hold SET.roadmap.json (`landscape export SET.landscape roadmap`) and SET.mujoco (`landscape export SET.parquet mujoco
--protocol dexgraspbench`). Of the relaxed ways whose ends hold at rest, the given number is taken, evenly from the rows.
"""

import argparse
import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from landscape._mujoco import _World, engine

Floats = NDArray[np.float64]

#: The main condition of docs/decisions/replay.md: times in seconds, and what counts as success.
HOLD_S, LEFT_S, NEAR_M, NEAR_RAD = 1.0, 0.25, 0.01, math.radians(15)
HOLDS, SUCCEEDS = "ends hold at 0.6 and 0", "succeeds at 0.6 and 0"


def product(one: Floats, other: Floats) -> Floats:
    """The product of two quaternions w, x, y, z."""
    w = one[0] * other[0] - one[1:] @ other[1:]
    return np.array([w, *(one[0] * other[1:] + other[0] * one[1:] + np.cross(one[1:], other[1:]))])


def rotated(quaternion: Floats, vector: Floats) -> Floats:
    """A vector, rotated."""
    twice = 2 * np.cross(quaternion[1:], vector)
    return vector + quaternion[0] * twice + np.cross(quaternion[1:], twice)


def angle(quaternion: Floats) -> float:
    """The angle of a rotation."""
    return 2 * math.atan2(float(np.linalg.norm(quaternion[1:])), abs(float(quaternion[0])))


def turned(symmetry: Any, turn: Floats) -> float:
    """The angle of a turn of the object modulo its symmetry."""
    if isinstance(symmetry, dict) and "sphere" in symmetry:
        return 0.0
    if isinstance(symmetry, dict) and "axis" in symmetry:
        axis = np.array(symmetry["axis"]["direction"])
        axis /= np.linalg.norm(axis)
        there = rotated(turn, axis)
        return math.atan2(float(np.linalg.norm(np.cross(axis, there))), float(axis @ there))
    copies = symmetry["finite"] if isinstance(symmetry, dict) else []
    motions = [np.array(copy["rotation"])[[3, 0, 1, 2]] for copy in copies]
    return min(angle(product(turn, motion)) for motion in [np.array([1.0, 0, 0, 0]), *motions])


def follows(mujoco: Any, model: Any, roadmap: dict[str, Any], points: list[dict[str, Any]]) -> bool:
    """Whether the object goes the way that its hand is driven."""
    world = _World(mujoco, model, 0)
    scale = roadmap["object_mass_kg"] / world.mass_kg
    model.body_mass[world.item] *= scale
    model.body_inertia[world.item] *= scale
    mujoco.mj_setConst(model, mujoco.MjData(model))
    data = world.data
    first, last = (np.array(points[k]["hand_from_object"]) for k in (0, -1))
    back = first[3:] * [1, -1, -1, -1]
    data.mocap_pos[0], data.mocap_quat[0] = -rotated(back, first[:3]), back
    moved = model.jnt_qposadr[model.actuator_trnid[:, 0]]
    data.qpos[moved] = points[0]["joints"]
    for one, other, terms in zip(model.eq_obj1id, model.eq_obj2id, model.eq_data):
        data.qpos[model.jnt_qposadr[one]] = terms[0] + terms[1] * data.qpos[model.jnt_qposadr[other]]
    data.qpos[world.start_at : world.start_at + 7] = [0, 0, 0, 1, 0, 0, 0]
    data.qvel[:] = 0
    mujoco.mj_forward(model, data)
    times = np.array([point["seconds"] for point in points])
    targets = np.array([point["targets"] for point in points])
    step_s = float(model.opt.timestep) * world.parts
    share = 1 - math.exp(-step_s / world.lag_s) if world.lag_s > 0 else 1.0
    control, apart = data.qpos[moved].copy(), 0
    for step in range(round((times[-1] + HOLD_S) / step_s)):
        target = np.array([np.interp(step * step_s, times, column) for column in targets.T])
        control += share * (target - control)
        data.ctrl[:] = control
        mujoco.mj_step(model, data, nstep=world.parts)
        apart = 0 if world.pressing() else apart + 1
        if apart * step_s > LEFT_S or not np.isfinite(data.qpos).all():
            return False
    place = data.qpos[world.start_at : world.start_at + 7]
    centre = np.array(roadmap["object_centre_m"])
    seen = rotated(first[3:], rotated(place[3:], centre) + place[:3]) + first[:3]
    off_m = float(np.linalg.norm(seen - rotated(last[3:], centre) - last[:3]))
    turn = product(last[3:] * [1, -1, -1, -1], product(first[3:], place[3:]))
    return off_m <= NEAR_M and turned(roadmap["object_symmetry"], turn) <= NEAR_RAD


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--table", type=Path, required=True)
    parser.add_argument("--ways", type=int, default=50)
    given = parser.parse_args()
    mujoco = engine()
    with given.table.open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["kind"] == "relaxed" and row[HOLDS] == "1"]
    counts = {(ours, theirs): 0 for ours in (True, False) for theirs in (True, False)}
    for row in rows[:: max(len(rows) // given.ways, 1)][: given.ways]:
        roadmap = json.loads((given.folder / f"{row['set']}.roadmap.json").read_text(encoding="utf-8"))
        ends = [int(row["from"]), int(row["to"])]
        edge = next(edge for edge in roadmap["edges"] if sorted(edge["ends"]) == sorted(ends))
        points = edge["trajectory"]
        if edge["ends"] != ends:
            lasting = points[0]["seconds"] + points[-1]["seconds"]
            points = [{**point, "seconds": lasting - point["seconds"]} for point in reversed(points)]
        model = mujoco.MjModel.from_xml_path(str(given.folder / f"{row['set']}.mujoco" / "scene.xml"))
        found = row[SUCCEEDS] == "1", follows(mujoco, model, roadmap, points)
        counts[found] += 1
        print(row["set"], ends, *found, flush=True)
    number = sum(counts.values())
    both = counts[True, True] + counts[False, False]
    print(f"{both} of {number} ways agree: both follow {counts[True, True]}, only Rapier {counts[True, False]}, "
          f"only MuJoCo {counts[False, True]}, neither {counts[False, False]}")


if __name__ == "__main__":
    main()
