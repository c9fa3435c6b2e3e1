"""Grasps: columns, round trips, and the same bytes as the command line."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import landscape as ls

LINE = [sys.executable, "-c", "import sys, landscape; sys.exit(landscape.main())"]


def line(*words, cwd):
    return subprocess.run([*LINE, *map(str, words)], cwd=cwd, check=True, capture_output=True, text=True).stdout


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Grasps of Python and of the command line."""
    folder = tmp_path_factory.mktemp("grasps")
    hand, ball = ls.Hand("human"), ls.Object("bottle_round")
    grasps = ls.synthesize(hand, ball, 6, seed=1, keep="all", out=folder / "python.parquet")
    line("synth", "--object", "bottle_round", "-n", 6, "--seed", 1, "--keep", "all", "-q", "-o", "line.parquet", cwd=folder)
    return folder, hand, ball, grasps


def test_synthesis_gives_the_bytes_of_the_command_line(made):
    folder, _, _, grasps = made
    assert (folder / "python.parquet").read_bytes() == (folder / "line.parquet").read_bytes()
    assert len(grasps) == 6 and grasps.poses.shape == (6, 29) and grasps.joints_rad.shape == (6, 22)
    assert grasps.translation_m.base is not None, "a view"
    with pytest.raises(ValueError, match="read-only"):
        grasps.poses[0, 0] = 1


def test_labels_give_the_bytes_of_the_command_line(made):
    folder, *_ = made
    ls.Grasps.read(folder / "line.parquet").label(out=folder / "labelled.python.parquet")
    line("label", "line.parquet", "-q", "-o", "labelled.line.parquet", cwd=folder)
    assert (folder / "labelled.python.parquet").read_bytes() == (folder / "labelled.line.parquet").read_bytes()


def test_build_gives_the_bytes_of_the_command_line(made):
    folder, *_ = made
    found = ls.Grasps.read(folder / "line.parquet").build(folder / "python.landscape", first=6, neighbours=1)
    words = ("--first", 6, "--neighbours", 1, "--no-report", "-q", "-o", "line.landscape")
    line("build", "line.parquet", *words, cwd=folder)
    names = sorted(path.name for path in (folder / "line.landscape").iterdir())
    assert "minima.parquet" in names
    for name in names:
        if name not in ("timings.json", "landscape.json", "summary.md"):
            same = (found.folder / name).read_bytes() == (folder / "line.landscape" / name).read_bytes()
            assert same, name
    # The page is no part of what the command records.
    assert (found.folder / "landscape.json").read_bytes() == (folder / "line.landscape" / "landscape.json").read_bytes()


def test_paths_have_their_energy_by_term(made):
    *_, grasps = made
    found = grasps[:4].build(neighbours=1)
    assert found.minima.rows > 1
    path = found.path(0, 1)
    assert sum(path.terms.values()) == pytest.approx(path.energy)
    assert path.height == pytest.approx(found.tree.merge_height(0, 1), rel=1e-3, abs=1e-3)


def test_energy_of_a_batch_is_that_of_the_file(made):
    _, hand, ball, grasps = made
    energy = ls.Energy(hand, ball)
    found = energy(grasps)
    assert found.energy == pytest.approx(grasps.energy, rel=1e-6, abs=1e-9)
    assert sum(found.terms.values()) == pytest.approx(found.energy)
    step = 1e-6
    tangents = np.zeros((6, found.gradient.shape[1]))
    tangents[:, 0] = step
    up, down = (energy.evaluate(energy.moved(grasps.poses, sign * tangents))[0] for sign in (1, -1))
    assert (up - down) / (2 * step) == pytest.approx(found.gradient[:, 0], rel=1e-3, abs=1e-3)


def test_arrays_and_back(made):
    _, hand, ball, grasps = made
    for form in ("wxyz", "xyzw", "matrix"):
        mine = ls.Grasps.from_arrays(
            hand, ball, translation_m=grasps.translation_m, rotation=grasps.rotation(form), rotation_form=form,
            joints_rad=grasps.joints_rad,
        )
        assert mine.poses == pytest.approx(grasps.poses, abs=1e-9), form
        assert mine.energy == pytest.approx(grasps.energy, rel=1e-6, abs=1e-9)
    scipy = pytest.importorskip("scipy.spatial.transform")
    turned = scipy.Rotation.from_quat(grasps.rotation("xyzw")).as_matrix()
    assert turned == pytest.approx(grasps.rotation("matrix"), abs=1e-9)


def test_rows_are_chosen(made):
    *_, grasps = made
    mask = grasps.energy < np.median(grasps.energy)
    assert list(grasps[mask].id) == list(grasps.id[mask])
    assert list(grasps[1:3].id) == [1, 2] and list(grasps[-1].id) == [5] and list(grasps[[4, 0]].id) == [4, 0]
    with pytest.raises(IndexError):
        grasps[6]
    with pytest.raises(IndexError):
        grasps[mask[:3]]


def test_tables_of_other_packages(made, tmp_path):
    _, hand, ball, grasps = made
    pytest.importorskip("pyarrow")
    frame = grasps.to_pandas()
    assert list(frame["energy"]) == list(grasps.energy) and len(grasps.to_polars()) == 6
    again = ls.Grasps.from_table(grasps.to_arrow())
    assert (again.poses == grasps.poses).all()
    for table in (frame, grasps.to_polars()):
        assert (ls.Grasps.from_table(table, hand=hand, object=ball).poses == grasps.poses).all()
    assert grasps.write(tmp_path / "x.parquet").is_file()


def test_judgement_and_simulation(made):
    *_, grasps = made
    judged = grasps.judge()
    assert (grasps.passes("strict") == np.array([each is None for each in judged.objection])).all()
    assert judged.epsilon == pytest.approx(grasps.epsilon)
    held = grasps[:2].stability()
    assert np.isin(held.stable, [0, 1]).all() and np.isnan(grasps.stable).all()


def test_errors_are_those_of_the_command_line(tmp_path):
    with pytest.raises(ls.InputError) as told:
        ls.Object("no_such_object")
    run = subprocess.run([*LINE, "synth", "--object", "no_such_object"], cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 1 and str(told.value).removeprefix("object ") in run.stderr
    (tmp_path / "bad.parquet").write_bytes(b"no table")
    with pytest.raises(ls.InputError, match="bad.parquet"):
        ls.Grasps.read(tmp_path / "bad.parquet")
    with pytest.raises(FileNotFoundError):
        ls.Grasps.read(tmp_path / "none.parquet")
    with pytest.raises(ls.InputError, match="has no mean|length 2"):
        ls.Grasps.from_arrays(
            ls.Hand("human"), ls.Object("ball"), translation_m=[[0, 0, 0.1]], rotation=[[2, 0, 0, 0]], rotation_form="wxyz",
            joints_rad=np.zeros((1, 22)),
        )


def test_an_object_from_a_mesh_in_memory():
    trimesh = pytest.importorskip("trimesh")
    box = ls.Object.from_trimesh(trimesh.creation.box(extents=[0.04, 0.06, 0.1]), name="box")
    assert box.name == "box" and box.distance([[0, 0, 0], [0.05, 0, 0]]) == pytest.approx([-0.02, 0.03])


def test_links_are_where_mujoco_has_them():
    mujoco = pytest.importorskip("mujoco")
    data = os.environ.get("LANDSCAPE_TEST_DATA")
    if data is None:
        pytest.skip("LANDSCAPE_TEST_DATA is not set")
    files = sorted(Path(data).rglob("shadow_right_primitives.xml"))
    if not files:
        pytest.skip("the test data have no MuJoCo hand")
    hand = ls.Hand(files[0])
    model = mujoco.MjModel.from_xml_path(str(files[0]))
    state = mujoco.MjData(model)
    rng, pose = np.random.default_rng(0), hand.rest_pose
    low, high = hand.limits_rad.T
    pose[7:] = rng.uniform(low, high)
    for name, angle in zip(hand.joint_names, pose[7:]):
        state.qpos[model.joint(name).qposadr[0]] = angle
    mujoco.mj_forward(model, state)
    frames = dict(zip(hand.link_names, hand.link_frames(pose)))
    shared = [body for body in range(1, model.nbody) if model.body(body).name in frames]
    assert len(shared) > 5
    first = shared[0]
    def matrix(body):
        m = np.eye(4)
        m[:3, :3], m[:3, 3] = state.xmat[body].reshape(3, 3), state.xpos[body]
        return m
    base = frames[model.body(first).name] @ np.linalg.inv(matrix(first))
    for body in shared:
        assert base @ matrix(body) == pytest.approx(frames[model.body(body).name], abs=1e-6)
