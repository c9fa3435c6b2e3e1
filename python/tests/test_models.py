"""Grasps and hands as models of other simulators, opened by their own readers."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

import landscape as ls


@pytest.fixture(scope="module", params=["human", "gripper_parallel"])
def held(request):
    """Grasps that hold in the test of DexGraspBench, as many as there are."""
    hand = ls.Hand(request.param)
    found = ls.synthesize(hand, ls.Object("bottle_round"), 8, seed=3).stability("dexgraspbench")
    return hand, found[found.stable == 1]


def body_frame(state, body):
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = state.xmat[body].reshape(3, 3), state.xpos[body]
    return frame


def test_what_holds_here_holds_in_mujoco(held, tmp_path):
    """Under gravity, for three seconds, with the forces of the test that they passed."""
    mujoco = pytest.importorskip("mujoco")
    hand, grasps = held
    assert len(grasps) >= 5
    scene = grasps.export(tmp_path / "scene", format="mujoco") / "scene.xml"
    model = mujoco.MjModel.from_xml_path(str(scene))
    state, item = mujoco.MjData(model), model.body("object").id
    assert model.nkey == len(grasps) and model.nu == len(hand.joint_names)
    assert model.nv - 6 >= model.nu
    ways, turns = [], []
    for key, pose in enumerate(grasps.poses):
        mujoco.mj_resetDataKeyframe(model, state, key)
        mujoco.mj_forward(model, state)
        frames = dict(zip(hand.link_names, hand.link_frames(pose)))
        for name in hand.link_names:
            assert body_frame(state, model.body(name).id) == pytest.approx(frames[name], abs=1e-9), name
        start, turned = state.xipos[item].copy(), state.xmat[item].reshape(3, 3).copy()
        mujoco.mj_step(model, state, nstep=round(3 / model.opt.timestep))
        ways.append(np.linalg.norm(state.xipos[item] - start))
        cosine = (np.trace(turned.T @ state.xmat[item].reshape(3, 3)) - 1) / 2
        turns.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    print(f"{hand.name}: {np.round(1e3 * np.array(ways), 1)} mm, {np.round(turns, 1)} degrees")
    # The test allows 50 mm and 15 degrees.
    assert max(ways) < 0.005 and max(turns) < 5


def test_the_forces_in_mujoco_are_gone_without_the_springs(held, tmp_path):
    """The keyframes hold because of their targets: with slack springs the object falls."""
    mujoco = pytest.importorskip("mujoco")
    _, grasps = held
    scene = grasps[:1].export(tmp_path / "scene", format="mujoco") / "scene.xml"
    model = mujoco.MjModel.from_xml_path(str(scene))
    state = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, state, 0)
    model.actuator_gainprm[:, 0] = model.actuator_biasprm[:, 1] = 0
    mujoco.mj_step(model, state, nstep=1500)
    assert state.body("object").xpos[2] < -0.05


def test_urdf_is_read_by_mujoco(held, tmp_path):
    mujoco = pytest.importorskip("mujoco")
    hand, grasps = held
    file = next(grasps.export(tmp_path / "hand", format="urdf").glob("*.urdf"))
    model = mujoco.MjModel.from_xml_path(str(file))
    state = mujoco.MjData(model)
    followers = {}
    for joint in ET.parse(file).iter("joint"):
        for mimic in joint.iter("mimic"):
            told = mimic.get("joint"), float(mimic.get("multiplier")), float(mimic.get("offset"))
            followers[joint.get("name")] = told
    assert model.njnt == len(hand.joint_names) + len(followers)
    rng = np.random.default_rng(0)
    for _ in range(5):
        pose = hand.rest_pose
        pose[7:] = rng.uniform(*hand.limits.T)
        for name, angle in zip(hand.joint_names, pose[7:]):
            state.qpos[model.joint(name).qposadr[0]] = angle
            assert model.joint(name).range == pytest.approx(hand.limits[hand.joint_names.index(name)])
        for name, (leader, multiplier, offset) in followers.items():
            angle = multiplier * state.qpos[model.joint(leader).qposadr[0]] + offset
            state.qpos[model.joint(name).qposadr[0]] = angle
        mujoco.mj_forward(model, state)
        frames = dict(zip(hand.link_names, hand.link_frames(pose)))
        bodies = [model.body(body).name for body in range(1, model.nbody)]
        assert bodies
        for name in bodies:
            assert body_frame(state, model.body(name).id) == pytest.approx(frames[name], abs=1e-9), name


def test_urdf_is_read_with_its_meshes(held, tmp_path):
    yourdfpy = pytest.importorskip("yourdfpy")
    hand, grasps = held
    file = next(grasps.export(tmp_path / "hand", format="urdf").glob("*.urdf"))
    robot = yourdfpy.URDF.load(str(file), build_collision_scene_graph=True, load_collision_meshes=True)
    assert set(robot.link_map) == set(hand.link_names)
    pose = hand.rest_pose
    robot.update_cfg(dict(zip(hand.joint_names, pose[7:])))
    frames = dict(zip(hand.link_names, hand.link_frames(pose)))
    for name in hand.link_names:
        assert robot.get_transform(name) == pytest.approx(frames[name], abs=1e-9), name
    assert robot.scene.bounds == pytest.approx(robot.collision_scene.bounds, abs=1e-3)
    assert 0.1 < robot.scene.scale < 0.6


def test_isaac_grasp_is_yaml_in_the_frame_of_the_object(held, tmp_path):
    yaml = pytest.importorskip("yaml")
    hand, grasps = held
    content = yaml.safe_load(grasps.export(tmp_path / "g.yaml", format="isaac_grasp").read_text())
    assert content["format"] == "isaac_grasp" and content["format_version"] == 1.0
    assert content["object_frame_link"] == "bottle_round" and content["gripper_frame_link"] == hand.link_names[0]
    assert list(content["grasps"]) == [f"grasp_{id}" for id in grasps.id]
    for told, pose in zip(content["grasps"].values(), grasps.poses):
        assert told["confidence"] == 1.0
        # The gripper in the frame of the object, as `compute_gripper_pose_from_rigid_body_pose` reads it.
        x, y, z = told["orientation"]["xyz"]
        w = told["orientation"]["w"]
        frame = hand.link_frames(pose)[0]
        assert told["position"] == pytest.approx(frame[:3, 3].tolist())
        turned = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
        assert turned == pytest.approx(frame[:3, 0])
        assert list(told["cspace_position"].values()) == pytest.approx(pose[7:].tolist())
        assert list(told["cspace_position"]) == list(told["pregrasp_cspace_position"]) == hand.joint_names


def test_dexonomy_is_a_dictionary_of_arrays(held, tmp_path):
    hand, grasps = held
    folder = grasps.export(tmp_path / "d", format="dexonomy")
    files = sorted(folder.glob("*.npy"))
    assert len(files) == len(grasps)
    for file, pose in zip(files, grasps.poses):
        content = np.load(file, allow_pickle=True).item()
        assert content["grasp_qpos"] == pytest.approx(pose, abs=1e-12)
        assert (content["pregrasp_qpos"] - content["grasp_qpos"])[:7] == pytest.approx(np.zeros(7))
        assert content["squeeze_qpos"].shape == content["pregrasp_qpos"].shape == pose.shape
        assert (content["obj_pose"] == [0, 0, 0, 1, 0, 0, 0]).all() and content["obj_scale"] == 1.0
        assert content["joint_names"] == hand.joint_names and content["hand_type"] == hand.name
    again = ls.import_grasps(folder, hand, ls.Object("bottle_round"))
    assert again.poses == pytest.approx(grasps.poses, abs=1e-12)


def test_usd_holds_hand_and_object(held, tmp_path):
    Usd = pytest.importorskip("pxr.Usd")
    from pxr import UsdGeom

    _, grasps = held
    folder = grasps[:2].export(tmp_path / "u", format="usd")
    files = sorted(folder.glob("*.usda"))
    assert len(files) == 2
    bottle = ls.Object("bottle_round")
    for file, contacts in zip(files, grasps[:2].contacts):
        stage = Usd.Stage.Open(str(file))
        assert UsdGeom.GetStageMetersPerUnit(stage) == 1 and UsdGeom.GetStageUpAxis(stage) == "Z"
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/grasp/object"))
        assert np.array(mesh.GetPointsAttr().Get()) == pytest.approx(bottle.vertices, abs=1e-6)
        assert UsdGeom.Mesh.ValidateTopology(
            mesh.GetFaceVertexIndicesAttr().Get(), mesh.GetFaceVertexCountsAttr().Get(), len(bottle.vertices)
        )[0]
        assert len(UsdGeom.Mesh(stage.GetPrimAtPath("/grasp/hand")).GetPointsAttr().Get()) >= 40
        spheres = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Sphere)]
        assert len(spheres) == len(contacts)
