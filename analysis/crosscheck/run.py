"""The drop test of `landscape stability` in MuJoCo and PyBullet, from what `crosscheck_export` wrote.

usage: run.py FOLDER [--first N]
"""

import argparse
import json
import pathlib

import mujoco
import numpy
import pybullet

SECONDS = 1000 / 60
NO_GRAVITY = [0.0, 0.0, 0.0]


def principal(inertia):
    """Moments and axes (columns, right-handed) of a symmetric matrix."""
    moments, axes = numpy.linalg.eigh(numpy.array(inertia).reshape(3, 3))
    if numpy.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    return moments, axes


def quaternion(axes):
    """w, x, y, z of a rotation matrix."""
    result = numpy.zeros(4)
    mujoco.mju_mat2Quat(result, axes.flatten())
    return result


def text(numbers):
    return " ".join(repr(float(number)) for number in numbers)


def fall_in_mujoco(folder, population, grasp, protocol, step_s):
    """Vertical way of the centre of mass, metres."""
    friction = protocol["friction"]["hand"] * protocol["friction"]["object"]
    moments, axes = principal(population["inertia_kg_m2"])
    meshes = "".join(
        f'<mesh name="p{n}" file="{folder / piece}" inertia="shell"/>' for n, piece in enumerate(population["pieces"])
    )
    # Inertia is given for the body, so the pieces have none; MuJoCo takes the larger of two frictions.
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
            impratio="10" noslip_iterations="2"/>
        <asset>{meshes}</asset><worldbody>{capsules}
        <body><freejoint/><inertial pos="{text(population["centre_m"])}" mass="{population["mass_kg"]!r}"
            diaginertia="{text(moments)}" quat="{text(quaternion(axes))}"/>{geoms}</body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
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


def fall_in_pybullet(folder, population, grasp, protocol, step_s):
    """Vertical way of the centre of mass, metres."""
    pybullet.resetSimulation()
    pybullet.setGravity(*NO_GRAVITY)
    pybullet.setTimeStep(step_s)
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
        pybullet.changeDynamics(body, -1, lateralFriction=protocol["friction"]["hand"])
    moments, axes = principal(population["inertia_kg_m2"])
    w, x, y, z = quaternion(axes)
    pieces = [str(folder / piece) for piece in population["pieces"]]
    shape = pybullet.createCollisionShapeArray(
        shapeTypes=[pybullet.GEOM_MESH] * len(pieces), fileNames=pieces, meshScales=[[1, 1, 1]] * len(pieces)
    )
    centre = population["centre_m"]
    body = pybullet.createMultiBody(
        population["mass_kg"],
        shape,
        basePosition=[0.0, 0.0, 0.0],
        baseInertialFramePosition=centre,
        baseInertialFrameOrientation=[x, y, z, w],
    )
    pybullet.changeDynamics(
        body,
        -1,
        lateralFriction=protocol["friction"]["object"],
        localInertiaDiagonal=moments.tolist(),
        linearDamping=0.0,
        angularDamping=0.0,
        collisionMargin=0.0,
    )
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


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--bullet-step", type=float, default=1 / 60, help="time step of PyBullet, seconds")
    parser.add_argument("--first", type=int, help="only so many grasps of each object")
    arguments = parser.parse_args()
    told = json.loads((arguments.folder / "grasps.json").read_text())
    protocol = told["protocol"]
    pybullet.connect(pybullet.DIRECT)
    rows = []
    print("object,id,landscape,landscape_m,mujoco_m,pybullet_m")
    for population in told["populations"]:
        for grasp in population["grasps"][: arguments.first]:
            ours = grasp["outcome"]
            heavy = (arguments.folder, population, grasp, protocol)
            mujoco_m = fall_in_mujoco(*heavy, 1 / 240)
            pybullet_m = fall_in_pybullet(*heavy, arguments.bullet_step)
            rows.append([ours["reason"] == "held", *(way < protocol["fall_m"] for way in (mujoco_m, pybullet_m))])
            print(
                f'{population["object"]},{grasp["id"]},{ours["reason"]},{ours["displacement_m"]:.4f},'
                f"{mujoco_m:.4f},{pybullet_m:.4f}",
                flush=True,
            )
    rows = numpy.array(rows)
    names = ["landscape", "MuJoCo", "PyBullet"]
    print(f"\n{len(rows)} grasps")
    for name, column in zip(names, rows.T):
        print(f"held in {name}: {100 * column.mean():.1f} %")
    for i, j in [(0, 1), (0, 2), (1, 2)]:
        print(f"{names[i]} and {names[j]} agree: {100 * (rows[:, i] == rows[:, j]).mean():.1f} %")


if __name__ == "__main__":
    main()
