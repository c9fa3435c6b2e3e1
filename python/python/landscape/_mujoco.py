"""The tests of ``landscape stability`` in MuJoCo: its scenes, the same numbers and the same criteria."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import InputError
from ._table import Table

Floats = NDArray[np.float64]

#: Overlap of hand and object above which a grasp fails at the start, metres, as in ``landscape stability``.
OVERLAP_M = 0.01
#: Longest step of MuJoCo, seconds: that of DexGraspBench.
LONGEST_STEP_S = 0.004
#: ``solref`` and ``solimp`` of all contacts. At rest they are springs of k d / (1 − d) = (2π · 60 Hz)², with k = 1/(d · 19 ms)²
#: and d = 0.98: as stiff as those of ``landscape stability``.
SOLREF, SOLIMP = (0.019, 1.0), (0.98, 0.98, 0.001)
#: Iterations against creep: as in DexGraspBench.
NOSLIP_ITERATIONS = 2
#: Inertia of each joint of a rigid hand, kg m²: nothing here turns it.
RIGID_KG_M2 = 1e8
#: Tolerance of the solver: that of MuJoCo itself.
TOLERANCE = 1e-8


@dataclass(frozen=True)
class Outcome:
    """What happened to a grasp; as in ``landscape stability``."""

    reason: str = "held"
    displacement_m: float = 0.0
    turn_rad: float = 0.0


def engine() -> Any:
    """The module ``mujoco``."""
    try:
        import mujoco
    except ImportError:
        raise InputError("simulation in MuJoCo needs the package mujoco: pip install mujoco") from None
    return mujoco


def outcomes(scene: Path) -> Table:
    """Simulates the grasps of a scene of ``landscape export FILE mujoco``, which names its test."""
    mujoco = engine()
    model = mujoco.MjModel.from_xml_path(str(scene))
    grasps = [_World(mujoco, model, key).outcome() for key in range(model.nkey)]
    return Table({
        "id": np.array([int(model.key(key).name) for key in range(model.nkey)], dtype=np.uint64),
        "stable": np.array([each.reason == "held" for each in grasps], dtype=bool),
        "stable_reason": [each.reason for each in grasps],
        "stable_displacement_m": np.array([each.displacement_m for each in grasps]),
        "stable_turn_rad": np.array([each.turn_rad for each in grasps]),
    })


class _World:
    """A grasp in the scene of a test."""

    def __init__(self, mujoco: Any, model: Any, key: int) -> None:
        self.mujoco, self.model = mujoco, model
        # The only text of these scenes.
        self.test: dict[str, Any] = json.loads(bytes(model.text_data).rstrip(b"\0"))
        self.item = model.body("object").id
        self.of_object = model.geom_bodyid == self.item
        self.start_at = model.joint("object").qposadr[0]
        self.moved_by = model.joint("object").dofadr[0]
        self.centre: Floats = model.body_ipos[self.item].copy()
        self.mass_kg = float(model.body_mass[self.item])
        self._prepare()
        self.data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, self.data, key)
        self.target: Floats = self.data.ctrl.copy()
        self.joints = model.jnt_qposadr[model.actuator_trnid[:, 0]]
        if self.lag_s > 0:
            self.data.ctrl[:] = self.data.qpos[self.joints]
        mujoco.mj_forward(model, self.data)
        self.palm: Floats = self.data.site("palm").xmat.reshape(3, 3).copy()

    def _prepare(self) -> None:
        """Steps, contacts and springs of the test. What the scene has already (mass, friction, targets) stays."""
        model, solver, closing = self.model, self.test["solver"], self.test.get("closing")
        joints = np.arange(model.nv) < model.joint("object").dofadr[0]
        longest_s = LONGEST_STEP_S
        armature = float(model.dof_armature[joints].min())
        if closing is not None:
            # MuJoCo cuts torques before a step: with longer steps a joint swings about its target.
            longest_s = min(longest_s, math.sqrt(armature / closing["stiffness_n_m"]))
        self.parts = max(solver["substeps"], math.ceil(solver["time_step_s"] / longest_s - 1e-9))
        step_s = model.opt.timestep = solver["time_step_s"] / self.parts
        model.opt.gravity[:] = 0
        model.opt.noslip_iterations = NOSLIP_ITERATIONS
        # A reset would put a lost object back into the hand.
        model.opt.disableflags |= self.mujoco.mjtDisableBit.mjDSBL_AUTORESET
        model.geom_solref[:] = SOLREF
        model.geom_solimp[:, :3] = SOLIMP
        # The other engines divide the velocity of a damped object so after each step.
        slowing = [self.test.get(f"{motion}_damping_per_s", 0.0) for motion in ("linear", "angular")]
        self.slowing = 1 / (1 + step_s * np.repeat(slowing, 3)) if any(slowing) else None
        self.lag_s = 0.0
        if closing is None or closing["rule"] == "none":
            model.dof_armature[joints] = RIGID_KG_M2
            model.actuator_gainprm[:, 0] = 0
            model.actuator_biasprm[:, 1:3] = 0
            # MuJoCo scales contacts by what the bodies weigh, and its tolerance by the mean inertia.
            model.opt.tolerance = TOLERANCE / RIGID_KG_M2
            self.mujoco.mj_setConst(model, self.mujoco.MjData(model))
            return
        # MuJoCo does not integrate a damping implicitly where it cuts the torque. Above the critical damping, a light joint
        # would hammer on the object; here its target moves at the speed of the spring, with the critical damping.
        stiffness, damping = closing["stiffness_n_m"], closing["damping_n_m_s"]
        critical = 2 * math.sqrt(stiffness * armature)
        if damping > critical:
            self.lag_s, damping = damping / stiffness, critical
        # The other engines integrate springs implicitly, MuJoCo only damping; −k (q + h v) is the same with h the step.
        model.actuator_biasprm[:, 2] = -model.actuator_gainprm[:, 0] * (damping / stiffness + step_s)

    def steps(self, seconds: float) -> int:
        """Steps of the test in some seconds."""
        return int(round(seconds / float(self.test["solver"]["time_step_s"])))

    def step(self) -> None:
        """One step of the test."""
        if self.slowing is None and self.lag_s == 0:
            self.mujoco.mj_step(self.model, self.data, nstep=self.parts)
            return
        for _ in range(self.parts):
            if self.lag_s > 0:
                self._move_targets()
            self.mujoco.mj_step(self.model, self.data)
            if self.slowing is not None:
                self.data.qvel[self.moved_by : self.moved_by + 6] *= self.slowing

    def _move_targets(self) -> None:
        """Moves the targets by a step toward their ends, at the speed (end − q) k / d of a spring without mass.

        No target is farther from its joint than where the torque reaches its limit: a joint that was blocked moves at that
        speed when it is free again, and does not catch up.
        """
        model, ends, before = self.model, self.target, self.data.ctrl.copy()
        joints = self.data.qpos[self.joints]
        moved = before + (ends - joints) * (float(model.opt.timestep) / self.lag_s)
        moved = np.clip(moved, np.minimum(before, ends), np.maximum(before, ends))
        reach = model.actuator_forcerange[:, 1] / model.actuator_gainprm[:, 0]
        self.data.ctrl[:] = np.clip(moved, joints - reach, joints + reach)

    def pose(self) -> tuple[Floats, Floats]:
        """Centre of mass of the object, and its quaternion w, x, y, z."""
        coordinates = self.data.qpos[self.start_at : self.start_at + 7]
        moved = np.empty(3)
        self.mujoco.mju_rotVecQuat(moved, self.centre, coordinates[3:])
        return moved + coordinates[:3], coordinates[3:].copy()

    def pressing(self) -> set[int]:
        """The digits that pressed on the object in the last step, 0 for the palm."""
        contacts = self.data.contact
        found = set()
        for geoms, address in zip(contacts.geom, contacts.efc_address):
            if address >= 0 and self.data.efc_force[address] > 0:
                (part,) = (geom for geom in geoms if not self.of_object[geom])
                found.add(int(self.model.body_user[self.model.geom_bodyid[part], 0]))
        return found

    def overlap_m(self) -> float:
        """Deepest overlap of hand and object."""
        return float(-min(self.data.contact.dist, default=0.0))

    def outcome(self) -> Outcome:
        """The outcome of the test."""
        if self.overlap_m() > OVERLAP_M:
            return Outcome("overlap")
        return self._fall() if "fall_m" in self.test else self._withstand()

    def _fall(self) -> Outcome:
        test, found = self.test, Outcome()
        gravity = np.array(test["gravity_m_s2"])
        down = gravity / np.linalg.norm(gravity)
        start, settling = self.pose(), self.steps(test["settle_s"])
        rest = _Rest(self)
        for step in range(settling + test["steps"]):
            if step == settling:
                self.model.opt.gravity[:] = gravity
            self.step()
            now = self.pose()
            way, turn_rad = _motion(start, now)
            if not np.isfinite([*way, turn_rad]).all():
                return replace(found, reason="lost")
            found = Outcome("held", float(np.linalg.norm(way)), turn_rad)
            if way @ down >= test["fall_m"]:
                return replace(found, reason="fell")
            if step >= settling and rest.reached(now):
                break
        return found

    def _withstand(self) -> Outcome:
        test, loads = self.test, self.test["loads"]
        found, start = Outcome(), self.pose()
        for _ in range(self.steps(test["closing"]["seconds"])):
            self.step()
            found = self._judged(found, start, counts=test["criterion"]["measured_from"] == "file")
            if found.reason != "held":
                return found
        size, kind = self._state()
        closed = np.empty(size)
        self.mujoco.mj_getState(self.model, self.data, closed, kind)
        forces = [self.force(np.array(direction, dtype=float)) for direction in loads["directions"]]
        trials = [forces[first : first + loads["together"]] for first in range(0, len(forces), loads["together"])]
        needed = {"all": len(trials), "half": (len(trials) + 1) // 2, "any": 1}[loads["needed"]]
        held, failed, open_ = found, None, len(trials)
        for trial in trials:
            self.mujoco.mj_setState(self.model, self.data, closed, kind)
            result = self._trial(found, start, trial)
            open_ -= 1
            if result.reason == "held":
                needed -= 1
                held = _worst(held, result)
            else:
                failed = result if failed is None else _worst(failed, result)
            if needed == 0:
                return held
            if open_ < needed:
                break
        return held if failed is None else _worst(failed, held)

    def _state(self) -> tuple[int, int]:
        kind = self.mujoco.mjtState.mjSTATE_INTEGRATION
        return self.mujoco.mj_stateSize(self.model, kind), kind

    def force(self, direction: Floats) -> Floats:
        """The force of a load, newtons."""
        loads = self.test["loads"]
        if loads["frame"] == "palm":
            direction = self.palm @ direction
        newtons = float(loads["acceleration_m_s2"]) * self.mass_kg
        return np.asarray(direction / np.linalg.norm(direction) * newtons)

    def _trial(self, found: Outcome, start: Any, forces: list[Floats]) -> Outcome:
        test, loads, criterion = self.test, self.test["loads"], self.test["criterion"]
        pushed = self.data.xfrc_applied[self.item, :3]
        if criterion["measured_from"] != "file":
            start = self.pose()
        for number, force in enumerate(forces):
            if number > 0:
                pushed[:] = 0
                for _ in range(self.steps(loads["pause_s"])):
                    self.step()
                    found = self._judged(found, start)
                    if found.reason != "held":
                        return found
                if criterion["measured_from"] == "load":
                    start = self.pose()
            pushed[:] = force
            rest = _Rest(self)
            for _ in range(self.steps(loads["seconds"])):
                self.step()
                found = self._judged(found, start)
                if found.reason != "held":
                    return found
                if rest.reached(self.pose()):
                    break
        digits = self.pressing()
        presses = {"none": True, "hand": len(digits) > 0, "digits": len(digits - {0}) >= 2}[criterion["contact"]]
        return found if presses else replace(found, reason="released")

    def _judged(self, found: Outcome, start: Any, counts: bool = True) -> Outcome:
        """The outcome so far, with the motion from ``start`` if it counts."""
        criterion = self.test["criterion"]
        way, turn_rad = _motion(start, self.pose())
        if not np.isfinite([*way, turn_rad]).all():
            return replace(found, reason="lost")
        if not counts:
            return found
        found = _worst(found, Outcome("", float(np.linalg.norm(way)), turn_rad))
        if found.displacement_m >= (criterion.get("displacement_m") or math.inf):
            return replace(found, reason="moved")
        if found.turn_rad >= (criterion.get("turn_rad") or math.inf):
            return replace(found, reason="turned")
        return found


class _Rest:
    """Whether no point of the object has moved farther than a limit for some time, as in ``landscape stability``."""

    def __init__(self, world: _World) -> None:
        rest = world.test["rest"]
        self.way_m, self.needed = rest["way_m"], max(world.steps(rest["time_s"]), 1)
        model = world.model
        geoms = np.flatnonzero(world.of_object)
        centres = np.linalg.norm(model.geom_pos[geoms] - world.centre, axis=1)
        self.reach_m = float((centres + model.geom_rbound[geoms]).max())
        self.anchor, self.near = world.pose(), 0

    def reached(self, pose: tuple[Floats, Floats]) -> bool:
        """Whether the object, now at ``pose``, rests."""
        way, turn_rad = _motion(self.anchor, pose)
        if np.linalg.norm(way) + turn_rad * self.reach_m > self.way_m:
            self.anchor, self.near = pose, 0
        else:
            self.near += 1
        return self.near >= self.needed


def _motion(start: tuple[Floats, Floats], now: tuple[Floats, Floats]) -> tuple[Floats, float]:
    """Way of the centre of mass, metres, and angle of the rotation, radians."""
    one, other = start[1], now[1]
    # The sine of half of the angle is the length of the part that is perpendicular.
    cosine = abs(float(one @ other))
    sine = float(np.linalg.norm(other - one * (one @ other)))
    return now[0] - start[0], 2 * math.atan2(sine, cosine)


def _worst(found: Outcome, other: Outcome) -> Outcome:
    """``found`` with the larger motions of both."""
    return replace(
        found,
        displacement_m=max(found.displacement_m, other.displacement_m),
        turn_rad=max(found.turn_rad, other.turn_rad),
    )
