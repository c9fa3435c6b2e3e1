"""The same hand in MuJoCo: where its links are, and how near they come to an object."""

from pathlib import Path

import numpy as np
import pytest

import landscape as ls

mujoco = pytest.importorskip("mujoco")

CLAW = Path(__file__).parents[1] / "tutorials/claw"


def body_frame(state, body):
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = state.xmat[body].reshape(3, 3), state.xpos[body]
    return frame


@pytest.fixture(scope="module")
def claw():
    return ls.Hand(CLAW / "claw.urdf"), ls.Object(CLAW / "bar.obj", scale=0.001)


@pytest.fixture(scope="module")
def held(claw):
    return ls.synthesize(*claw, 12, seed=1, keep="all")


@pytest.fixture(scope="module")
def model(claw):
    """The claw on a free joint, and the bar at the origin."""
    _, bar = claw
    spec = mujoco.MjSpec()
    palm = spec.worldbody.add_body(name="carrier")
    palm.add_freejoint()
    spec.attach(mujoco.MjSpec.from_file(str(CLAW / "claw.urdf")), prefix="hand/", frame=palm.add_frame())
    spec.add_mesh(name="bar", uservert=bar.vertices.ravel(), userface=bar.triangles.ravel().astype(int))
    spec.worldbody.add_geom(name="bar", type=mujoco.mjtGeom.mjGEOM_MESH, meshname="bar")
    return spec.compile()


def test_exported_grasps_pose_the_links_alike(claw, held, model, tmp_path):
    hand, _ = claw
    rows = np.load(held.export(tmp_path / "q.npy", format="qpos"))
    state = mujoco.MjData(model)
    for row, pose in zip(rows, held.poses):
        state.qpos[:] = row
        mujoco.mj_forward(model, state)
        frames = dict(zip(hand.link_names, hand.link_frames(pose)))
        assert set(hand.link_names) >= {"palm", "one_distal"}
        for name in hand.link_names:
            assert body_frame(state, model.body(f"hand/{name}").id) == pytest.approx(frames[name], abs=1e-9), name


def test_links_are_as_near_to_the_object(claw, held, model, tmp_path):
    """The signed distance of a contact is that of its link, as MuJoCo measures it, unless a corner of the link is nearer."""
    hand, bar = claw
    rows = np.load(held.export(tmp_path / "q.npy", format="qpos"))
    state, bar_geom = mujoco.MjData(model), model.geom("bar").id
    met = 0
    for row, contacts, pose in zip(rows, held.judgement.contacts, held.poses):
        state.qpos[:] = row
        mujoco.mj_forward(model, state)
        points = hand.surface_points(pose)
        for point, link, distance in map(dict.values, contacts):
            assert bar.distance(points[[point]])[0] == pytest.approx(distance, abs=1e-9)
            body = model.body(f"hand/{link}").id
            geoms = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] == body]
            nearest = min(mujoco.mj_geomDistance(model, state, geom, bar_geom, 1.0, None) for geom in geoms)
            assert nearest <= distance + 1e-4
            assert nearest > distance - 0.004
            met += 1
    assert met >= 12


def test_links_of_a_published_hand(test_data):
    file = test_data / "hands/shadow_dexonomy/shadow_right_primitives.xml"
    hand = ls.Hand(file)
    model = mujoco.MjModel.from_xml_path(str(file))
    state = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    for _ in range(5):
        pose = hand.rest_pose
        pose[7:] = rng.uniform(*hand.limits_rad.T)
        for name, angle in zip(hand.joint_names, pose[7:]):
            state.qpos[model.joint(name).qposadr[0]] = angle
        mujoco.mj_forward(model, state)
        frames = dict(zip(hand.link_names, hand.link_frames(pose)))
        shared = [body for body in range(1, model.nbody) if model.body(body).name in frames]
        assert len(shared) > 5
        base = frames[model.body(shared[0]).name] @ np.linalg.inv(body_frame(state, shared[0]))
        for body in shared:
            assert base @ body_frame(state, body) == pytest.approx(frames[model.body(body).name], abs=1e-6)
