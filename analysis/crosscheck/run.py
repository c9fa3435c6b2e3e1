"""Repeats the drop test of `landscape stability` in MuJoCo and PyBullet, with the files that `crosscheck_export` wrote.

usage: run.py FOLDER [--first N] [--engines NAME ...]
"""

import argparse
import functools
import itertools
import json
import math
import pathlib

import mujoco
import numpy
import scipy.optimize

try:
    import pybullet
except ImportError:  # The engines of MuJoCo need only MuJoCo.
    pybullet = None

SECONDS = 1000 / 60
# Margin that PyBullet adds around every convex hull by default, metres.
MARGIN_M = 1e-3
# Contacts nearer than this count as touching, metres.
TOUCH_M = 1e-4
# Lever by which turns are converted to displacements, metres.
LEVER_M = 0.05
# Impedance (`solimp`) of contacts in MuJoCo when they are springs.
IMPEDANCE = 0.98
NO_GRAVITY = [0.0, 0.0, 0.0]


def principal(inertia):
    """Returns the moments and the axes (columns, right-handed) of a symmetric matrix."""
    moments, axes = numpy.linalg.eigh(numpy.array(inertia).reshape(3, 3))
    if numpy.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    return moments, axes


def quaternion(axes):
    """Converts a rotation matrix to w, x, y, z."""
    result = numpy.zeros(4)
    mujoco.mju_mat2Quat(result, axes.flatten())
    return result


def text(numbers):
    return " ".join(repr(float(number)) for number in numbers)


def fall_in_mujoco(folder, population, grasp, protocol, step_s=1 / 240, springs=False):
    """Vertical way of the centre of mass, metres."""
    # In MuJoCo, contacts with friction slip a little under any load, so objects creep out of the hand within the 17 s. A
    # large impratio reduces this.
    friction = protocol["friction"]
    moments, axes = principal(population["inertia_kg_m2"])
    meshes = "".join(
        f'<mesh name="p{n}" file="{folder / piece}" inertia="shell"/>' for n, piece in enumerate(population["pieces"])
    )
    # The body has the inertia, so its pieces have none. MuJoCo uses the larger of the two frictions of a contact.
    geoms = "".join(
        f'<geom type="mesh" mesh="p{n}" mass="0" friction="{friction} 0 0" contype="1" conaffinity="2"/>'
        for n in range(len(population["pieces"]))
    )
    capsules = "".join(
        f'<geom type="capsule" fromto="{text(c["a"])} {text(c["b"])}" size="{c["radius_m"]!r}" '
        f'friction="{friction} 0 0" contype="2" conaffinity="1"/>'
        for c in grasp["capsules"]
        if numpy.linalg.norm(numpy.subtract(c["a"], c["b"])) > 1e-9
    ) + "".join(
        f'<geom type="sphere" pos="{text(c["a"])}" size="{c["radius_m"]!r}" '
        f'friction="{friction} 0 0" contype="2" conaffinity="1"/>'
        for c in grasp["capsules"]
        if numpy.linalg.norm(numpy.subtract(c["a"], c["b"])) <= 1e-9
    )
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><compiler inertiafromgeom="false"/>
        <option timestep="{step_s!r}" gravity="{text(NO_GRAVITY)}" integrator="implicitfast" cone="elliptic"
            impratio="100" noslip_iterations="2"/>
        <asset>{meshes}</asset><worldbody>{capsules}
        <body><freejoint/><inertial pos="{text(population["centre_m"])}" mass="{population["mass_kg"]!r}"
            diaginertia="{text(moments)}" quat="{text(quaternion(axes))}"/>{geoms}</body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    if springs:
        give_springs_in_mujoco(model, data, population, protocol)
    body = model.nbody - 1
    start = data.xipos[body][2]
    for _ in range(round(protocol["settle_s"] / step_s)):
        mujoco.mj_step(model, data)
    model.opt.gravity[:] = protocol["gravity_m_s2"]
    for _ in range(round(SECONDS / step_s)):
        mujoco.mj_step(model, data)
        if start - data.xipos[body][2] >= protocol["fall_m"]:
            break
    return float(start - data.xipos[body][2])


def place_in_pybullet(folder, population, grasp, protocol, margin_m=0.0):
    """Places hand and object without gravity and returns the body of the object."""
    pybullet.resetSimulation()
    pybullet.setGravity(*NO_GRAVITY)
    # Bullet multiplies the frictions of two bodies.
    friction = math.sqrt(protocol["friction"])
    for c in grasp["capsules"]:
        a, b = numpy.array(c["a"]), numpy.array(c["b"])
        length = float(numpy.linalg.norm(b - a))
        along = (b - a) / length if length > 1e-9 else numpy.array([0.0, 0.0, 1.0])
        shape = pybullet.createCollisionShape(pybullet.GEOM_CAPSULE, radius=c["radius_m"], height=length)
        across = numpy.cross([0.0, 0.0, 1.0], along)
        turn = numpy.array([*across, 1.0 + along[2]])
        if numpy.linalg.norm(turn) < 1e-9:
            turn = numpy.array([1.0, 0.0, 0.0, 0.0])
        body = pybullet.createMultiBody(0, shape, basePosition=(a + b) / 2, baseOrientation=turn / numpy.linalg.norm(turn))
        pybullet.changeDynamics(body, -1, lateralFriction=friction)
    moments, axes = principal(population["inertia_kg_m2"])
    w, x, y, z = quaternion(axes)
    # PyBullet makes one hull for each piece of the file. It would use only the first 16 of a list of shapes, without a warning.
    shape = pybullet.createCollisionShape(pybullet.GEOM_MESH, fileName=str(folder / population["all_pieces"]))
    body = pybullet.createMultiBody(
        population["mass_kg"],
        shape,
        basePosition=[0.0, 0.0, 0.0],
        baseInertialFramePosition=population["centre_m"],
        baseInertialFrameOrientation=[x, y, z, w],
    )
    pybullet.changeDynamics(
        body,
        -1,
        lateralFriction=friction,
        localInertiaDiagonal=moments.tolist(),
        linearDamping=0.0,
        angularDamping=0.0,
        collisionMargin=margin_m,
    )
    return body


def fall_in_pybullet(folder, population, grasp, protocol, step_s=1 / 60, margin_m=0.0, iterations=50, springs=False):
    """Vertical way of the centre of mass, metres."""
    body = place_in_pybullet(folder, population, grasp, protocol, margin_m)
    if springs:
        give_springs_in_pybullet(body, population, protocol)
    pybullet.setPhysicsEngineParameter(fixedTimeStep=step_s, numSolverIterations=iterations)
    start = pybullet.getBasePositionAndOrientation(body)[0][2]
    for _ in range(round(protocol["settle_s"] / step_s)):
        pybullet.stepSimulation()
    pybullet.setGravity(*protocol["gravity_m_s2"])
    for _ in range(round(SECONDS / step_s)):
        pybullet.stepSimulation()
        low = pybullet.getBasePositionAndOrientation(body)[0][2]
        if start - low >= protocol["fall_m"]:
            break
    return start - low


def pushes_in_pybullet(body, population):
    """Returns, for each contact of the object, the unit force that opens it and its torque about the centre of mass (metres)."""
    pybullet.performCollisionDetection()
    pushes = []
    for contact in pybullet.getContactPoints(body):
        _, first, _, _, _, on_first, on_second, normal, distance, *_ = contact
        if distance > TOUCH_M:
            continue
        is_first = first == body
        push = numpy.array(normal) * (1.0 if is_first else -1.0)
        arm = numpy.subtract(on_first if is_first else on_second, population["centre_m"])
        pushes.append((push, numpy.cross(arm, push)))
    return pushes


def pushes_in_mujoco(model, data, population):
    """The same of MuJoCo's contacts. The object is the last body."""
    pushes = []
    for contact in data.contact:
        if contact.dist > TOUCH_M:
            continue
        # The first axis of the frame points from the first to the second geom.
        is_second = model.geom_bodyid[contact.geom[1]] == model.nbody - 1
        push = contact.frame[:3] * (1.0 if is_second else -1.0)
        arm = contact.pos - population["centre_m"]
        pushes.append((push, numpy.cross(arm, push)))
    return pushes


def our_springs(pushes, population, protocol):
    """Returns the mass (kg), angular frequency (1/s) and damping ratio of the springs that model contacts in `landscape`. The
    frequency holds for the effective mass of a contact; the mean over the contacts at the start stands for all of them."""
    inverse = numpy.linalg.inv(numpy.array(population["inertia_kg_m2"]).reshape(3, 3))
    masses = [1.0 / (1.0 / population["mass_kg"] + torque @ inverse @ torque) for _, torque in pushes]
    mass_kg = numpy.mean(masses) if masses else population["mass_kg"]
    contact = protocol["contact"]
    return mass_kg, 2.0 * numpy.pi * contact["frequency_hz"], contact["damping"]


def give_springs_in_pybullet(body, population, protocol):
    """Makes contacts the same springs as in `landscape`. The hand stays stiff, because Bullet combines the two in series."""
    pushes = pushes_in_pybullet(body, population)
    mass_kg, omega, damping = our_springs(pushes, population, protocol)
    pybullet.changeDynamics(
        body, -1, contactStiffness=mass_kg * omega**2, contactDamping=2.0 * damping * mass_kg * omega
    )


def give_springs_in_mujoco(model, data, population, protocol):
    """Makes contacts at rest as stiff as in `landscape`. MuJoCo gives the stiffness per mass of the whole body, for a
    constraint with the impedance IMPEDANCE. The rest, 1 - IMPEDANCE, also resists acceleration: with 0.98, contacts move like
    springs with little more than critical damping. With 0.9, steps of 1/240 s are too long for the damping."""
    pushes = pushes_in_mujoco(model, data, population)
    mass_kg, omega, damping = our_springs(pushes, population, protocol)
    soft = (1.0 - IMPEDANCE) * mass_kg / population["mass_kg"]
    model.geom_solref[:] = [-soft * omega**2, -soft * 2.0 * damping * omega]
    model.geom_solimp[:] = [IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0]
    mujoco.mj_forward(model, data)


def escape(folder, population, grasp, protocol):
    """Measures how freely the object could leave the hand without friction: the largest speed at which all contacts open at
    once, among motions of speed 1 (metres, and turns at a lever of LEVER_M). It is 0 if the normals alone hold the object."""
    body = place_in_pybullet(folder, population, grasp, protocol)
    rows = [[*push, *(torque / LEVER_M)] for push, torque in pushes_in_pybullet(body, population)]
    if not rows:
        return 1.0
    opening = numpy.array(rows)
    # Largest t with t ≤ opening · motion for every contact and |motion| ≤ 1 in each of its six numbers.
    solved = scipy.optimize.linprog(
        [0.0] * 6 + [-1.0],
        A_ub=numpy.hstack([-opening, numpy.ones((len(rows), 1))]),
        b_ub=numpy.zeros(len(rows)),
        bounds=[(-1.0, 1.0)] * 6 + [(None, None)],
    )
    return float(solved.x[-1])


# The first two engines have contacts that are as stiff at rest as in `landscape`, and steps as long as its substeps. The others
# have their default contacts. By default PyBullet adds a margin to hulls; `exact` is without this margin. The contact forces
# of PyBullet grow as its step gets shorter.
ENGINES = {
    "mujoco-springs": functools.partial(fall_in_mujoco, springs=True),
    "pybullet-springs": functools.partial(fall_in_pybullet, step_s=1 / 240, iterations=500, springs=True),
    "mujoco": fall_in_mujoco,
    "pybullet": functools.partial(fall_in_pybullet, margin_m=MARGIN_M),
    "pybullet-exact": fall_in_pybullet,
    "pybullet-exact-240": functools.partial(fall_in_pybullet, step_s=1 / 240),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--engines", nargs="+", choices=ENGINES, default=list(ENGINES), help="the engines to run")
    parser.add_argument("--first", type=int, help="greatest number of grasps of each object")
    arguments = parser.parse_args()
    told = json.loads((arguments.folder / "grasps.json").read_text())
    protocol = told["protocol"] | {"contact": told["contact"]}
    if pybullet:
        pybullet.connect(pybullet.DIRECT)
    elif any(name.startswith("pybullet") for name in arguments.engines):
        parser.error("these engines need the package pybullet; --engines mujoco-springs mujoco does not")
    names = ["landscape", *arguments.engines]
    rows = []
    print("object,id,escape,landscape," + ",".join(f"{name}_m" for name in names))
    for population in told["populations"]:
        for grasp in population["grasps"][: arguments.first]:
            ours = grasp["outcome"]
            ways = [
                ENGINES[name](arguments.folder, population, grasp, protocol) for name in arguments.engines
            ]
            free = escape(arguments.folder, population, grasp, protocol) if pybullet else math.nan
            rows.append([ours["reason"] == "held", *(way < protocol["fall_m"] for way in ways)])
            print(
                f'{population["object"]},{grasp["id"]},{free:.4f},{ours["reason"]},{ours["displacement_m"]:.4f},'
                + ",".join(f"{way:.4f}" for way in ways),
                flush=True,
            )
    rows = numpy.array(rows)
    print(f"\n{len(rows)} grasps")
    for name, column in zip(names, rows.T):
        print(f"held in {name}: {100 * column.mean():.1f} %")
    for i, j in itertools.combinations(range(len(names)), 2):
        print(f"{names[i]} and {names[j]} agree: {100 * (rows[:, i] == rows[:, j]).mean():.1f} %")


if __name__ == "__main__":
    main()
