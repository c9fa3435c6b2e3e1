"""Grasps for and from other programs."""

import json

import numpy as np
import pytest

import landscape as ls


@pytest.mark.parametrize("format", ["csv", "json"])
def test_tables_come_back_to_the_last_bit(hand, bottle, grasps, tmp_path, format):
    file = grasps.export(tmp_path / f"grasps.{format}", format=format)
    again = ls.import_grasps(file, hand, bottle)
    assert (again.poses == grasps.poses).all()
    assert again.energy == pytest.approx(grasps.energy, rel=1e-9)
    assert all((one == other).all() for one, other in zip(again.contacts, grasps.contacts))


def test_dexgraspnet_goes_out_and_in(hand, bottle, grasps, tmp_path):
    file = grasps.export(tmp_path / "grasps.npy", format="dexgraspnet")
    rows = np.load(file, allow_pickle=True)
    assert len(rows) == 6 and set(hand.joint_names) <= set(rows[0]["qpos"])
    assert rows[2]["qpos"]["WRJTx"] == pytest.approx(grasps.translation_m[2, 0])
    again = ls.import_grasps(file, hand, bottle, out=tmp_path / "again.parquet")
    assert again.poses == pytest.approx(grasps.poses, abs=1e-9)
    assert (tmp_path / "again.parquet").is_file() and again.populations == [("human", "bottle_round", 1.0, 6)]


def test_a_mirrored_hand_is_named(bottle, grasps, tmp_path):
    file = grasps.export(tmp_path / "grasps.csv", format="csv")
    left = ls.Hand("human", mirror=True)
    assert set(ls.import_grasps(file, left, bottle).hand) == {left.name}


def test_a_table_of_another_form_needs_a_mapping(hand, bottle, grasps, tmp_path):
    rows = [
        {"t": (100 * t).tolist(), "q": q.tolist(), "angles": np.degrees(joints).tolist()}
        for t, q, joints in zip(grasps.translation_m, grasps.rotation("xyzw"), grasps.joints)
    ]
    file, mapping = tmp_path / "mine.json", tmp_path / "mapping.toml"
    file.write_text(json.dumps(rows))
    with pytest.raises(ls.InputError):
        ls.import_grasps(file, hand, bottle)
    # In another unit they are all over the place, and the right one is named.
    mapping.write_text('translation = "t"\nrotation = "q"\nrotation_form = "xyzw"\njoints = "angles"\njoint_unit = "deg"\n')
    with pytest.raises(ls.InputError, match='`translation_unit = "cm"`'):
        ls.import_grasps(file, hand, bottle, mapping=mapping)
    mapping.write_text(
        'translation = "t"\ntranslation_unit = "cm"\nrotation = "q"\nrotation_form = "xyzw"\n'
        'joints = "angles"\njoint_unit = "deg"\n'
    )
    again = ls.import_grasps(file, hand, bottle, mapping=mapping)
    assert again.poses == pytest.approx(grasps.poses, abs=1e-9)


def test_acronym_is_read(tmp_path):
    h5py = pytest.importorskip("h5py")
    file = tmp_path / "mug.h5"
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[0, :3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    poses[:, :3, 3] = [0, 0, -0.08]
    with h5py.File(file, "w") as content:
        content["grasps/transforms"] = poses
        content["gripper/configuration"] = [0.04]
    gripper = ls.Hand("gripper_parallel")
    with pytest.raises(ls.InputError, match="it has no object/scale, so it is no file of ACRONYM"):
        ls.import_grasps(file, gripper, ls.Object("ball"))
    with h5py.File(file, "a") as content:
        content["object/scale"] = 0.75
    found = ls.import_grasps(file, gripper, ls.Object("ball"))
    half = 0.5**0.5
    assert found.poses == pytest.approx(np.array([[0, 0, -0.08, half, 0, 0, half, 0.04], [0, 0, -0.08, 1, 0, 0, 0, 0.04]]))
    assert found.populations == [("gripper_parallel", "ball", 0.75, 2)]


def test_a_doubt_is_a_warning(hand, bottle, grasps, tmp_path):
    rows = [
        {"translation_m": t.tolist(), "rotation_wxyz": q.tolist(), "joints": joints.tolist()}
        for t, q, joints in zip(grasps.translation_m, grasps.rotation("xyzw"), grasps.joints)
    ]
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(rows))
    with pytest.warns(UserWarning, match='`rotation_form = "xyzw"`'):
        ls.import_grasps(file, hand, bottle)


def test_qpos_is_position_quaternion_and_joints(grasps, tmp_path):
    rows = np.load(grasps.export(tmp_path / "q.npy", format="qpos"))
    assert rows.shape == (6, 29)
    assert np.sort(rows[:, 7:], axis=1) == pytest.approx(np.sort(grasps.joints, axis=1), abs=1e-12)
    header, first, *_ = grasps.export(tmp_path / "q.csv", format="qpos").read_text().splitlines()
    assert header.startswith("id,x,y,z,qw")
    assert [float(x) for x in first.split(",")] == pytest.approx([0, *rows[0]])


def test_scenes_hold_the_object_where_it_is(bottle, grasps, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    folder = grasps[:2].export(tmp_path / "scenes", format="glb")
    scenes = [trimesh.load_scene(file) for file in sorted(folder.glob("*.glb"))]
    assert len(scenes) == 2
    low, high = bottle.vertices.min(axis=0), bottle.vertices.max(axis=0)
    for scene in scenes:
        sizes = [sorted(part.extents) for part in scene.dump()]
        assert any(size == pytest.approx(sorted(high - low), abs=1e-4) for size in sizes)
        assert len(sizes) > 1


def test_published_grasps_are_read(test_data):
    """DexGraspNet's mug: the fourth-nearest contact lies near the surface."""
    file = next((test_data / "dexgraspnet/original_npy").glob("core-mug*.npy"))
    mesh = (test_data / "dexgraspnet/meshes" / file.name).with_suffix(".obj")
    hand = ls.Hand(test_data / "hands/shadow_dexgraspnet/shadow_hand_vis.xml")
    found = ls.import_grasps(file, hand, ls.Object(mesh))
    given = np.load(file, allow_pickle=True)
    assert len(found) <= len(given) and len(found) > 0.9 * len(given)
    assert sorted({scale for *_, scale, _ in found.populations}) == pytest.approx([0.06, 0.08, 0.1, 0.12, 0.15])
    names = [name.split(":")[-1] for name in hand.joint_names]
    rows = {tuple(np.round([row["qpos"][f"WRJT{axis}"] for axis in "xyz"], 6)): row["qpos"] for row in given}
    for translation, joints in zip(found.translation_m, found.joints):
        row = rows[tuple(np.round(translation, 6))]
        assert joints == pytest.approx([row[f"robot0:{name}"] for name in names], abs=1e-6)
