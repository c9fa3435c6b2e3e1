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
        pose[7:] = rng.uniform(*hand.limits.T)
        for name, angle in zip(hand.joint_names, pose[7:]):
            state.qpos[model.joint(name).qposadr[0]] = angle
        mujoco.mj_forward(model, state)
        frames = dict(zip(hand.link_names, hand.link_frames(pose)))
        shared = [body for body in range(1, model.nbody) if model.body(body).name in frames]
        assert len(shared) > 5
        base = frames[model.body(shared[0]).name] @ np.linalg.inv(body_frame(state, shared[0]))
        for body in shared:
            assert base @ body_frame(state, body) == pytest.approx(frames[model.body(body).name], abs=1e-6)


#: Where the palm stands in the world of the file: as in the Shadow, Allegro and LEAP hands of MuJoCo Menagerie.
PALMS = {"shadow": ("0 0 0.034", "1 0 0 0"), "allegro": ("0 0 0", "0 1 0 1"), "leap": ("0 0 0.1", "0 1 0 0")}

TWO_FINGERS = """<mujoco><compiler angle="radian" autolimits="true"/><worldbody>
<body name="palm" pos="{}" quat="{}"><geom type="box" size="0.04 0.02 0.012"/>
<body name="one" pos="0.045 0 0.012"><joint name="one" axis="0 -1 0" range="-0.6 1.2"/>
<geom type="capsule" fromto="0 0 0 0 0 0.07" size="0.008"/></body>
<body name="two" pos="-0.045 0 0.012"><joint name="two" axis="0 1 0" range="-0.6 1.2"/>
<geom type="capsule" fromto="0 0 0 0 0 0.07" size="0.008"/></body></body></worldbody></mujoco>"""


def attached(file):
    """The hand as DexGraspBench and Dexonomy load it: the world of the file becomes a body with a free joint."""
    spec = mujoco.MjSpec()
    frame = spec.worldbody.add_frame()
    frame.attach_body(mujoco.MjSpec.from_file(str(file)).worldbody, "child-", "").add_freejoint()
    return spec.compile()


def assert_links_alike(model, hand, qpos, pose):
    state = mujoco.MjData(model)
    state.qpos[:] = qpos
    mujoco.mj_forward(model, state)
    frames = dict(zip(hand.link_names, hand.link_frames(pose)))
    shared = [body for body in range(model.nbody) if model.body(body).name.removeprefix("child-") in frames]
    moving = [body for body in shared if model.body(body).name != "world"]
    assert len(moving) >= 3
    for body in moving:
        expected = frames[model.body(body).name.removeprefix("child-")]
        # A tenth of a millimetre is what a user would see; nothing but rounding is left.
        assert body_frame(state, body) == pytest.approx(expected, abs=1e-9), model.body(body).name


@pytest.mark.parametrize("palm", PALMS)
def test_benchmarks_find_the_hand_where_it_was(palm, tmp_path):
    """Exported, loaded their way, and imported again."""
    file = tmp_path / "hand.xml"
    file.write_text(TWO_FINGERS.format(*PALMS[palm]))
    hand, ball = ls.Hand(file), ls.Object("ball")
    grasps = ls.synthesize(hand, ball, 3, seed=1, keep="all")
    model = attached(file)
    folder = grasps.export(tmp_path / "d", format="dexonomy")
    files = sorted(folder.glob("*.npy"))
    rows = np.load(grasps.export(tmp_path / "q.npy", format="qpos"))
    assert len(files) == len(rows) == len(grasps) > 0
    for written, row, pose in zip(files, rows, grasps.poses):
        qpos = np.load(written, allow_pickle=True).item()["grasp_qpos"]
        assert qpos == pytest.approx(row)
        assert_links_alike(model, hand, qpos, pose)
    assert ls.import_grasps(folder, hand, ball).poses == pytest.approx(grasps.poses, abs=1e-12)
    assert ls.import_grasps(tmp_path / "q.npy", hand, ball).poses == pytest.approx(grasps.poses, abs=1e-12)


def test_a_grasp_of_a_benchmark_is_where_mujoco_has_it(tmp_path):
    """Their file, read here: the object stands elsewhere than at the origin, in a nested scene."""
    file = tmp_path / "hand.xml"
    file.write_text(TWO_FINGERS.format(*PALMS["leap"]))
    hand, ball = ls.Hand(file), ls.Object("ball")
    qpos = np.array([0.3, -0.2, 0.15, 0.5, 0.5, -0.5, 0.5, 0.2, 0.3])
    stand = np.array([0.25, -0.15, 0.1, np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    scene = {"scene": {"ball": {"type": "rigid_object", "scale": np.ones(3), "pose": stand}}, "task": {"obj_name": "ball"}}
    np.save(tmp_path / "g.npy", {"grasp_qpos": qpos[None], "scene_cfg": scene}, allow_pickle=True)
    found = ls.import_grasps(tmp_path / "g.npy", hand, ball)
    model = attached(file)
    state = mujoco.MjData(model)
    state.qpos[:] = qpos
    mujoco.mj_forward(model, state)
    world_from_object = np.eye(4)
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, stand[3:])
    world_from_object[:3, :3], world_from_object[:3, 3] = matrix.reshape(3, 3), stand[:3]
    frames = dict(zip(hand.link_names, hand.link_frames(found.poses[0])))
    for name in ["palm", "one", "two"]:
        in_world = world_from_object @ frames[name]
        assert body_frame(state, model.body(f"child-{name}").id) == pytest.approx(in_world, abs=1e-9), name
