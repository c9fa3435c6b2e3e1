"""The hand in the page stands as in Rust: frames of links, and the meshes of a grasp."""

import numpy as np
import pyarrow.parquet as pq
import pytest

import landscape as ls
import made

POSES = 20


def posed(hand, desk, opened):
    """Poses a hand at random in the page and in Rust."""
    rest = hand.rest_pose[None]
    parts = {"translation_m": rest[:, :3], "rotation": rest[:, 3:7], "joints": rest[:, 7:]}
    grasp = ls.Grasps.from_arrays(hand, ls.Object("ball"), rotation_form="wxyz", **parts)
    grasp.write(desk.folder / "h.parquet")
    desk.succeed("report", "h.parquet", "-q")
    rng = np.random.default_rng(9)
    poses = rng.uniform(-1, 1, (POSES, 7 + len(hand.joint_names)))
    poses[:, 3:7] /= np.linalg.norm(poses[:, 3:7], axis=1, keepdims=True)
    low, high = np.clip(hand.limits, -3, 3).T
    poses[:, 7:] = rng.uniform(low, high, (POSES, len(low)))
    told = opened(desk.folder / "h.grasps.html").act(
        "return given.map(x => Array.from(poseLinks(model.header.hands[0], Float64Array.from(x))));", poses.tolist()
    )
    for pose, frames in zip(poses, told):
        frames = np.reshape(frames, (-1, 12))
        ours = hand.link_frames(pose)
        assert np.allclose(frames[:, :9].reshape(-1, 3, 3), ours[:, :3, :3], atol=1e-6)
        assert np.allclose(frames[:, 9:], ours[:, :3, 3], atol=1e-6)


@pytest.mark.parametrize("name", ["human", "gripper_parallel", "gripper_three_finger"])
def test_hands_are_posed_as_in_rust(name, desk, opened):
    """Hands with hinges, and with mimicked and sliding joints."""
    posed(ls.Hand(name), desk, opened)


def test_ball_joints_are_posed_as_in_rust(desk, opened):
    posed(ls.Hand(made.mano(desk.folder / "mano.npz")), desk, opened)


def test_a_published_hand_is_posed_as_in_rust(desk, opened, test_data):
    posed(ls.Hand(test_data / "hands/urdf/shadow_hand_right_nomesh.urdf"), desk, opened)


def test_a_grasp_stands_as_the_program_exports_it(desk, opened):
    trimesh = pytest.importorskip("trimesh")
    table = made.grasps(3)
    pq.write_table(table, desk.folder / "g.parquet")
    desk.succeed("report", "g.parquet", "-q")
    for grasp in table["id"].to_pylist():
        desk.succeed("export", "g.parquet", "glb", "--grasp", grasp, "-o", f"{grasp}.glb", "-q")
        tab = opened(desk.folder / "g.grasps.html", f"sel=%23{grasp}")
        tab.act("await settled(); byId('export-open').click(); await settled();")
        saved, name = tab.saved("save-scene-glb")
        (desk.folder / name).write_bytes(saved)
        ours, theirs = (trimesh.load(desk.folder / file, process=False).geometry for file in (f"{grasp}.glb", name))
        thing, hand = sorted(theirs.values(), key=lambda mesh: len(mesh.vertices))
        assert np.abs(thing.vertices - ours["object"].vertices).max() < 1e-5
        # The skin of the page is finer than the exported one.
        assert np.abs(hand.bounds - ours["hand"].bounds).max() < 2e-3
        # The view shows something.
        pixels = tab.act("""
const { canvas } = panels.scene.views[0];
const flat = document.createElement("canvas");
[flat.width, flat.height] = [canvas.width, canvas.height];
const context = flat.getContext("2d");
context.drawImage(canvas, 0, 0);
return context.getImageData(0, 0, flat.width, flat.height).data.filter((value, k) => k % 4 === 3 && value > 127).length / (flat.width * flat.height);
""")
        assert 0.05 < pixels < 0.9
