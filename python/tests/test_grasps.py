"""Grasps: columns, round trips, judgement, errors."""

import subprocess
import sys

import numpy as np
import pytest

import landscape as ls


def test_columns_are_views(grasps):
    assert len(grasps) == 6 and grasps.poses.shape == (6, 29) and grasps.joints.shape == (6, 22)
    assert grasps.translation_m.base is not None, "a view"
    with pytest.raises(ValueError, match="read-only"):
        grasps.poses[0, 0] = 1


def test_paths_have_their_energy_by_term(mapped):
    assert mapped.minima.rows > 1
    path = mapped.path(0, 1)
    assert sum(path.terms.values()) == pytest.approx(path.energy)
    assert path.height == pytest.approx(mapped.tree.merge_height(0, 1), rel=1e-3, abs=1e-3)


def test_energy_of_a_batch_is_that_of_the_file(hand, bottle, grasps):
    energy = ls.Energy(hand, bottle)
    found = energy(grasps)
    assert found.energy == pytest.approx(grasps.energy, rel=1e-6, abs=1e-9)
    assert sum(found.terms.values()) == pytest.approx(found.energy)
    step = 1e-6
    tangents = np.zeros((6, found.gradient.shape[1]))
    tangents[:, 0] = step
    up, down = (energy.evaluate(energy.moved(grasps.poses, sign * tangents))[0] for sign in (1, -1))
    assert (up - down) / (2 * step) == pytest.approx(found.gradient[:, 0], rel=1e-3, abs=1e-3)


def test_arrays_and_back(hand, bottle, grasps):
    for form in ("wxyz", "xyzw", "matrix"):
        mine = ls.Grasps.from_arrays(
            hand, bottle, translation_m=grasps.translation_m, rotation=grasps.rotation(form), rotation_form=form,
            joints=grasps.joints,
        )
        assert mine.poses == pytest.approx(grasps.poses, abs=1e-9), form
        assert mine.energy == pytest.approx(grasps.energy, rel=1e-6, abs=1e-9)
    scipy = pytest.importorskip("scipy.spatial.transform")
    turned = scipy.Rotation.from_quat(grasps.rotation("xyzw")).as_matrix()
    assert turned == pytest.approx(grasps.rotation("matrix"), abs=1e-9)


def test_rows_are_chosen(grasps):
    mask = grasps.energy < np.median(grasps.energy)
    assert list(grasps[mask].id) == list(grasps.id[mask])
    assert list(grasps[1:3].id) == [1, 2] and list(grasps[-1].id) == [5] and list(grasps[[4, 0]].id) == [4, 0]
    with pytest.raises(IndexError):
        grasps[6]
    with pytest.raises(IndexError):
        grasps[mask[:3]]


def test_tables_of_other_packages(hand, bottle, grasps, tmp_path):
    pytest.importorskip("pyarrow")
    frame = grasps.to_pandas()
    assert list(frame["energy"]) == list(grasps.energy) and len(grasps.to_polars()) == 6
    again = ls.Grasps.from_table(grasps.to_arrow())
    assert (again.poses == grasps.poses).all()
    for table in (frame, grasps.to_polars()):
        assert (ls.Grasps.from_table(table, hand=hand, object=bottle).poses == grasps.poses).all()
    assert grasps.write(tmp_path / "x.parquet").is_file()


@pytest.mark.parametrize("package", ["pandas", "polars", "pyarrow"])
def test_judgements_are_tables_of_other_packages(grasps, package):
    pytest.importorskip(package)
    judged = grasps.judge()
    table = getattr(judged, f"to_{package.removeprefix('py')}")()
    assert len(table) == 6
    frame = table if package == "pandas" else table.to_pandas()
    assert [list(row) for row in frame["contacts"]] == judged.contacts
    assert set(judged.contacts[0][0]) == {"point", "link", "distance_m"}


def test_a_mask_may_choose_no_grasp(hand, bottle, grasps):
    none = grasps[grasps.energy > np.inf]
    assert len(none) == len(none.to_pandas()) == len(none.to_polars()) == none.judge().rows == 0 and "0 grasps" in repr(none)
    assert list(none.to_pandas()) == list(grasps.to_pandas())
    assert none.poses.shape == (0, 29) and none.joints.shape == (0, 22)
    energy, gradient, terms = ls.Energy(hand, bottle)(none)
    assert energy.shape == (0,) and gradient.shape == (0, 28) and all(term.shape == (0,) for term in terms.values())


def test_an_energy_refuses_grasps_of_another_object(hand, bottle, grasps):
    with pytest.raises(ls.InputError, match="row 0 is of the object 'bottle_round' .* but the energy is of 'ball'"):
        ls.Energy(hand, ls.Object("ball"))(grasps)
    with pytest.raises(ls.InputError, match="at scale 1.0, but .* at scale 0.5"):
        ls.Energy(hand, ls.Object("bottle_round", scale=0.5)).evaluate(grasps)
    pyarrow = pytest.importorskip("pyarrow")
    table = grasps.to_arrow()
    place = table.schema.get_field_index("scale")
    scales = pyarrow.array([1.0, 1.0, 1.0, 0.9, 0.9, 1.0])
    several = ls.Grasps.from_table(table.set_column(place, table.schema.field("scale"), scales))
    with pytest.raises(ls.InputError, match="row 3 is of the object 'bottle_round' at scale 0.9"):
        ls.Energy(hand, bottle)(several)
    assert len(ls.Energy(hand, bottle)(several[:3]).energy) == 3


def test_files_of_others_are_not_replaced(grasps, tmp_path):
    file = tmp_path / "own.parquet"
    file.write_text("mine")
    with pytest.raises(ls.InputError, match="not made by landscape .*--force"):
        grasps.write(file)
    with pytest.raises(ls.InputError, match="not made by landscape .*--force"):
        grasps.label(out=file)
    assert file.read_text() == "mine"
    grasps[:2].write(file, force=True)
    assert len(ls.Grasps.read(grasps.write(file))) == 6, "our own files are replaced"


def test_judgement_and_simulation(grasps):
    judged = grasps.judge()
    assert (grasps.passes("strict") == np.array([each is None for each in judged.objection])).all()
    assert judged.epsilon == pytest.approx(grasps.epsilon)
    held = grasps[:2].stability()
    assert np.isin(held.stable, [0, 1]).all() and np.isnan(grasps.stable).all()


def test_errors_are_those_of_the_command_line(tmp_path):
    line = [sys.executable, "-c", "import sys, landscape; sys.exit(landscape.main())"]
    with pytest.raises(ls.InputError) as told:
        ls.Object("no_such_object")
    run = subprocess.run([*line, "synth", "--object", "no_such_object"], cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 1 and str(told.value).removeprefix("object ") in run.stderr
    (tmp_path / "bad.parquet").write_bytes(b"no table")
    with pytest.raises(ls.InputError, match="bad.parquet"):
        ls.Grasps.read(tmp_path / "bad.parquet")
    with pytest.raises(FileNotFoundError):
        ls.Grasps.read(tmp_path / "none.parquet")
    with pytest.raises(ls.InputError, match="has no mean|length 2"):
        ls.Grasps.from_arrays(
            ls.Hand("human"), ls.Object("ball"), translation_m=[[0, 0, 0.1]], rotation=[[2, 0, 0, 0]], rotation_form="wxyz",
            joints=np.zeros((1, 22)),
        )


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"contacts": [[-1]]}, "contacts: row 0 has -1"),
        ({"contacts": [3]}, "contacts: a list of whole numbers"),
        ({"rotation": [[1, 0, 0, 0], [1]]}, "rotation: an array of numbers is needed"),
        ({"hand": "human"}, "hand: a landscape.Hand is needed, not str"),
        ({"object": None}, "object: a landscape.Object is needed, not NoneType"),
    ],
)
def test_wrong_arrays_are_told(hand, bottle, grasps, given, words):
    usual = dict(
        hand=hand, object=bottle, translation_m=grasps.translation_m[:1], rotation=grasps.rotation_wxyz[:1],
        rotation_form="wxyz", joints=grasps.joints[:1],
    )
    assert len(ls.Grasps.from_arrays(**usual, contacts=[np.array([3, 5, 9])])) == 1
    with pytest.raises(ls.InputError, match=words):
        ls.Grasps.from_arrays(**{**usual, **given})


def test_what_is_no_hand_object_or_seed_is_told(hand, bottle, grasps):
    for call, words in [
        (lambda: ls.Energy("human", bottle), "hand: a landscape.Hand is needed"),
        (lambda: ls.Energy(hand, "ball"), "object: a landscape.Object is needed"),
        (lambda: ls.synthesize(hand, bottle, 2, seed=-1), "seed -1: a whole number from 0"),
        (lambda: ls.build("grasps.parquet"), "grasps: a landscape.Grasps is needed"),
        (lambda: grasps.build(seed=0.5), "seed 0.5: a whole number"),
        (lambda: ls.Object.from_mesh([[0, 0, 0], [1]], [[0, 1, 2]]), "vertices: an array of numbers"),
    ]:
        with pytest.raises(ls.InputError, match=words):
            call()


def test_an_object_from_a_mesh_in_memory():
    trimesh = pytest.importorskip("trimesh")
    box = ls.Object.from_trimesh(trimesh.creation.box(extents=[0.04, 0.06, 0.1]), name="box")
    assert box.name == "box" and box.distance([[0, 0, 0], [0.05, 0, 0]]) == pytest.approx([-0.02, 0.03])


def test_an_open_surface_becomes_a_wall_with_a_thickness():
    corners = [[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]]
    triangles = [[0, 1, 2], [0, 2, 3]]
    with pytest.raises(ls.InputError, match="is not closed"):
        ls.Object.from_mesh(corners, triangles)
    sheet = ls.Object.from_mesh(corners, triangles, name="sheet", thickness_mm=4)
    assert sheet.distance([[0.05, 0.05, 0], [0.05, 0.05, 0.01]]) == pytest.approx([-0.002, 0.008], abs=2e-4)
    with pytest.raises(ls.InputError, match="thickness_mm 0 is not from 0.1"):
        ls.Object.from_mesh(corners, triangles, thickness_mm=0)


def test_grasps_are_asked_for(hand, tmp_path):
    pen = ls.Object("pen")
    found = ls.synthesize(hand, pen, 3, grips=["thumb+index"], out=tmp_path / "pinches.parquet")
    assert "--grips thumb+index" in found.metadata["command"]
    assert found.metadata["settings"]["asked"] == [{"digits": ["index", "thumb"]}]
    more = ls.synthesize(hand, pen, 8, keep="all", beyond=found, apart_mm=8, chance=0.2)
    assert "--beyond pinches.parquet --apart 8" in more.metadata["command"]
    with pytest.raises(ls.InputError, match="33 grasp types"):
        ls.synthesize(hand, pen, 1, types=["Tip Punch"])
    # All given grasps are minima already, and stay; the others come after them.
    filled = found.refine(8, beyond=found, keep="all")
    assert "--from pinches.parquet --beyond pinches.parquet" in filled.metadata["command"]
    assert len(filled) > len(found)
    assert len(found.refine(perturb_mm=2, keep="all")) == len(found)
