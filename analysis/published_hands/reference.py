"""MuJoCo's kinematics of the published hands in `hands/dex_urdf` of `LANDSCAPE_TEST_DATA` → `tests/published/dex_urdf/*.json`

Needs `mujoco`. Only names of links and joints and the places of links are written: at zero, and at five random
configurations within the limits.
"""

import json
import os
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np

HANDS = Path(os.environ["LANDSCAPE_TEST_DATA"]) / "hands/dex_urdf"
OUT = Path(__file__).parents[2] / "tests/published/dex_urdf"

for file in sorted(HANDS.glob("*/*.urdf")):
    robot = ET.parse(file).getroot()
    for link in robot.findall("link"):
        for part in link.findall("visual") + link.findall("collision") + link.findall("inertial"):
            link.remove(part)
    # The places of links do not depend on masses.
    compiler = '<mujoco><compiler fusestatic="false" boundmass="0.01" boundinertia="1e-5"/></mujoco>'
    robot.append(ET.fromstring(compiler))
    model = mujoco.MjModel.from_xml_string(ET.tostring(robot, encoding="unicode"))
    state = mujoco.MjData(model)
    followers = {}
    for joint in robot.findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            factors = float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0))
            followers[joint.get("name")] = (mimic.get("joint"), *factors)
    joints = [model.joint(j).name for j in range(model.njnt)]
    free = [name for name in joints if name not in followers]
    ranges = np.array([model.joint(name).range if model.joint(name).type[0] >= 2 else [0, 0] for name in free])
    limited = np.array([bool(model.jnt_limited[model.joint(name).id]) for name in free])
    ranges[~limited] = [-3, 3]
    rng = np.random.default_rng(0)
    configurations = []
    for k in range(6):
        qpos = np.zeros(len(free)) if k == 0 else rng.uniform(*ranges.T)
        angles = dict(zip(free, qpos))
        for name in joints:
            leader, ratio, offset = followers.get(name, (name, 1.0, 0.0))
            state.qpos[model.joint(name).qposadr[0]] = ratio * angles[leader] + offset
        mujoco.mj_kinematics(model, state)
        bodies = {
            model.body(b).name: {
                "pos": state.xpos[b].round(12).tolist(),
                "quat_wxyz": state.xquat[b].round(12).tolist(),
            }
            for b in range(1, model.nbody)
        }
        configurations.append({"qpos": qpos.tolist(), "bodies": bodies})
    content = {
        "model": f"dex_urdf/{file.parent.name}/{file.name}",
        "mujoco_version": mujoco.__version__,
        "joint_order": free,
        "joint_range": ranges.tolist(),
        "configurations": configurations,
    }
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / f"{file.parent.name}.json").write_text(json.dumps(content) + "\n")
    print(file.name, len(free), "joints", len(followers), "followers", model.nbody - 1, "bodies")
