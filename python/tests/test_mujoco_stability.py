"""The published tests in MuJoCo."""

import sys

import numpy as np
import pytest

import landscape as ls
from landscape._mujoco import _World


@pytest.fixture(scope="module")
def two(hand, bottle):
    """A grasp that holds, and the same hand half a metre away."""
    found = ls.synthesize(hand, bottle, 4, seed=3)[:1]
    away = found.translation_m + [0.5, 0.0, 0.0]
    apart = ls.Grasps.from_arrays(
        hand, bottle, translation_m=away, rotation=found.rotation_wxyz, rotation_form="wxyz", joints=found.joints,
        contacts=[row.tolist() for row in found.contacts],
    )
    return found, apart


@pytest.mark.parametrize(("protocol", "reason"), [("dexgraspbench", "moved"), ("drop", "fell")])
def test_one_holds_and_one_falls(two, protocol, reason):
    pytest.importorskip("mujoco")
    held, apart = (grasps.stability_in_mujoco(protocol) for grasps in two)
    assert held.stable.tolist() == [True] and held.stable_reason == ["held"]
    assert held.id.tolist() == two[0].id.tolist() and held.stable_displacement_m[0] < 0.01
    assert apart.stable.tolist() == [False] and apart.stable_reason == [reason]
    assert not np.isnan(apart.stable_displacement_m).any()


def test_the_object_of_gendexgrasp_is_damped(two, tmp_path):
    """Free, at an acceleration a and a damping c, it moves by (a / c) (t - (1 - exp(-c t)) / c)."""
    mujoco = pytest.importorskip("mujoco")
    scene = two[1].export(tmp_path / "scene", format="mujoco", protocol="gendexgrasp") / "scene.xml"
    world = _World(mujoco, mujoco.MjModel.from_xml_path(str(scene)), 0)
    start, _ = world.pose()
    world.data.xfrc_applied[world.item, :3] = world.force(np.array([1.0, 0.0, 0.0]))
    for _ in range(world.steps(1.0)):
        world.step()
    end, _ = world.pose()
    assert end - start == pytest.approx([0.5 / 10 * (1 - (1 - np.exp(-10)) / 10), 0, 0], rel=0.02, abs=1e-6)


def test_a_joint_with_much_damping_does_not_catch_up(two, tmp_path):
    """Free, it moves to its target as 1 − exp(−k t / d); when it was blocked for a second, it then moves at that speed."""
    mujoco = pytest.importorskip("mujoco")
    scene = two[1].export(tmp_path / "scene", format="mujoco", protocol="gendexgrasp") / "scene.xml"
    world = _World(mujoco, mujoco.MjModel.from_xml_path(str(scene)), 0)
    start = world.data.qpos[world.joints]
    limits = world.model.jnt_range[world.model.actuator_trnid[:, 0]]
    way = np.clip(limits.mean(axis=1) - start, -0.3, 0.3)
    assert np.abs(way).max() == pytest.approx(0.3)
    world.target = start + way
    for _ in range(world.steps(1.0)):
        world.step()
        world.data.qpos[world.joints] = start
        world.data.qvel[: len(start)] = 0
    for seconds, share in [(0.1, 1 - np.exp(-0.1)), (1.0, 1 - np.exp(-1.1))]:
        for _ in range(world.steps(seconds)):
            world.step()
        assert world.data.qpos[world.joints] - start == pytest.approx(share * way, abs=0.01)


def test_a_scene_has_memory_for_a_squeeze(two, tmp_path):
    """By itself MuJoCo takes 15 MB, and a hand of balls that squeezes a can makes 443 contacts, which need more."""
    mujoco = pytest.importorskip("mujoco")
    scene = two[0].export(tmp_path / "scene", format="mujoco", protocol="gendexgrasp") / "scene.xml"
    assert mujoco.MjModel.from_xml_path(str(scene)).narena == 256 * 2**20


def test_a_missing_package_is_named(two, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ls.InputError, match="pip install mujoco"):
        two[0].stability_in_mujoco("dexgraspbench")
