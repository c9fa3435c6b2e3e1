"""Landscapes: what is computed from them, and files in and out."""

import json
from pathlib import Path

import numpy as np
import pytest
from lines import ONE

import landscape as ls


@pytest.fixture(scope="module")
def cluster():
    """Seven Lennard-Jones atoms."""
    return ls.explore("lj 7")


def partition(found, temperature):
    """Harmonic partition functions of the minima without common factors, from the numbers in ``stationary``."""
    orders = [float(row.split()[2]) for row in (found.folder / "min.data").read_text().splitlines()]
    minima = found.stationary.where(found.stationary["index"] == 0)
    logs = [
        -0.5 * np.log(curvatures[curvatures > 1e-6]).sum() - np.log(order) - energy / temperature
        for curvatures, order, energy in zip(minima.curvatures, orders, minima.energy)
    ]
    return np.exp(np.array(logs) - max(logs))


def test_heat_capacity_is_that_of_harmonic_wells(cluster):
    told = cluster.thermodynamics(temperatures="0.05:0.3x6")
    assert len(told["curves"]) == 6
    for at in told["curves"]:
        temperature = at["temperature"]
        share = partition(cluster, temperature)
        share /= share.sum()
        energy = cluster.minima.energy
        spread = (share * energy**2).sum() - (share * energy).sum() ** 2
        # Each of 15 vibrations holds kT; the occupation adds the rest.
        assert at["heat_capacity"] == pytest.approx(15 + spread / temperature**2, rel=1e-6)
        assert at["energy"] == pytest.approx((share * energy).sum() + 15 * temperature, rel=1e-6)


def test_rates_are_in_detailed_balance(cluster, tmp_path):
    told = cluster.rates([1], ["m0"], [0.1, 0.2], out=tmp_path / "rates")
    assert told["sources"] == [1] and told["targets"] == [0] and (tmp_path / "rates.svg").is_file()
    for at in told["at"]:
        share = partition(cluster, at["temperature"])
        forward, backward = (at[way]["log_steady_state_rate"] for way in ("forward", "backward"))
        assert forward - backward == pytest.approx(np.log(share[0] / share[1]), abs=1e-6)
        assert at["pathways"][0]["minima"][0] == 1 and at["pathways"][0]["minima"][-1] == 0
    single = cluster.rates([1], [0], 0.1)
    assert single["at"][0]["forward"] == told["at"][0]["forward"]
    slow = cluster.rates([1], [0], 0.1, friction=1e3)["at"][0]["forward"]
    assert slow["log_steady_state_rate"] < single["at"][0]["forward"]["log_steady_state_rate"] - 1


def test_diff_pairs_minima(cluster):
    other = ls.explore("lj 7", seed=5)
    same = cluster.diff(other)
    assert list(same.matches.before) == list(same.matches.after) == [0, 1, 2, 3]
    assert same.matches.energy_before == pytest.approx(same.matches.energy_after, abs=1e-8)
    assert same.only_before == [] and same.only_after == [] and same.possible.rows == 0 and len(same.to_pandas()) == 4
    with pytest.raises(ls.InputError):
        cluster.diff(ls.explore("muller-brown"))


def test_diff_tells_what_only_one_has():
    def wells(count):
        return lambda x: (np.cos(count * x).sum(), -count * np.sin(count * x))

    two, three = (ls.explore(wells(count), ls.Torus(1), name="wells") for count in (2, 3))
    told = two.diff(three, within=0.1)
    assert told.matches.rows == 0 and told.only_before == [0, 1] and told.only_after == [0, 1, 2]
    # The wells of the two lie a sixth of π apart and are equally deep.
    near = two.diff(three, within=0.2)
    assert near.only_before == [] and near.possible.distance == pytest.approx(np.pi / 6)
    assert two.diff(three, within=1.0).matches.rows > 0


def test_compare_tells_of_the_taxonomy(mapped, tmp_path):
    text = mapped.compare(out=tmp_path / "one")
    assert "taxonomy" in text.lower()
    written = json.loads((tmp_path / "one.json").read_text())
    assert written and (tmp_path / "one.md").stat().st_size > 100
    both = mapped.compare(mapped, seed=3)
    assert both != text and "type" in both
    with pytest.raises(ls.InputError, match="this needs one of grasps"):
        ls.explore("muller-brown").compare()


def test_pages(cluster, mapped, grasps, tmp_path):
    one, two, of_grasps = (
        cluster.report(tmp_path / "one.html"), mapped.report(tmp_path / "two.html", other=mapped),
        grasps.report(tmp_path / "grasps.html"),
    )
    texts = [page.read_text(encoding="utf-8") for page in (one, two, of_grasps)]
    assert all(text.startswith("<!") and "</html>" in text for text in texts)
    assert len(set(map(len, texts))) == 3
    beside = cluster.save(tmp_path / "kept.landscape")
    assert beside.report() == tmp_path / "kept.report.html" and beside.report().is_file()
    assert beside.newick() == cluster.newick()


def test_pictures(cluster, mapped, tmp_path):
    assert b"<svg" in cluster.draw(tmp_path / "tree.svg", levels=10).read_bytes()[:400]
    assert cluster.draw(tmp_path / "few.png", lowest=2).read_bytes().startswith(b"\x89PNG")
    folder = mapped.draw(tmp_path / "all", colour="category", examples=2)
    assert {"disconnectivity.svg", "barriers.png", "tree.nwk"} <= {path.name for path in folder.iterdir()}


def test_a_temporary_landscape_lives_as_long_as_its_tree_and_its_page():
    tree = ls.explore("lj 7").tree
    assert tree.newick().count(",") == 3 and tree.to_dict() and "graph" in tree.dot()
    assert "</html>" in ls.explore("muller-brown").report().read_text(encoding="utf-8")


def test_nothing_is_said_of_files_that_are_not_kept(cluster, mapped, capfd):
    cluster.thermodynamics(temperatures="0.05:0.3x6")
    cluster.rates([1], [0], 0.1)
    mapped.compare()
    assert capfd.readouterr() == ("", "")


def test_a_minimum_is_a_path_to_itself(cluster, mapped):
    for found in (cluster, mapped):
        path = found.path(1, 1)
        assert path.height == found.minima.energy[1] == found.tree.merge_height(1, 1)
        assert (path.coordinates == found.minima.coordinates[1:2]).all() and list(path.length) == [0] and path.top == 0
    for call in (cluster.path, cluster.tree.merge_height):
        with pytest.raises(ls.InputError, match="a -1: a whole number from 0"):
            call(-1, 0)


def test_pictures_have_their_endings_and_their_makers(cluster, tmp_path):
    with pytest.raises(ls.InputError, match=r"\.svg or \.png"):
        cluster.draw(tmp_path / "tree.pdf")
    own = tmp_path / "own.svg"
    own.write_text("<svg/>")
    with pytest.raises(ls.InputError, match="not made by landscape .*--force"):
        cluster.draw(own)
    assert own.read_text() == "<svg/>"
    first = cluster.draw(own, force=True).read_bytes()
    assert cluster.draw(own, levels=5).read_bytes() != first, "our own files are replaced"


def test_pictures_of_a_path(cluster, mapped, tmp_path):
    png, svg, glb = mapped.draw_path(0, 1, tmp_path / "way.0-1", pictures=3)
    assert png.name == "way.0-1.png" and png.read_bytes().startswith(b"\x89PNG")
    assert b"<svg" in svg.read_bytes()[:400] and glb.read_bytes().startswith(b"glTF")
    with pytest.raises(ls.InputError, match="same minimum"):
        mapped.draw_path(1, 1, tmp_path / "none")
    with pytest.raises(ls.InputError, match="this needs one of grasps"):
        cluster.draw_path(0, 1, tmp_path / "none")


def test_pathsample_files_go_out_and_in(cluster, tmp_path):
    written = cluster.write_pathsample(tmp_path / "sample")
    assert sorted(path.name for path in written.iterdir()) == ["min.data", "points.min", "points.ts", "ts.data"]
    points = np.fromfile(written / "points.min").reshape(4, 21)
    assert points == pytest.approx(cluster.minima.coordinates, abs=1e-12)
    again = ls.import_landscape(written, tmp_path / "again.landscape")
    assert again.minima.energy == pytest.approx(cluster.minima.energy, abs=1e-6)
    assert again.tree.heights() == pytest.approx(cluster.tree.heights(), abs=1e-6)
    assert again.coverage is None
    with pytest.raises(ls.InputError, match="with min.data and ts.data is needed"):
        ls.import_landscape(Path(__file__).parents[2] / "data/grasps.parquet")
    rates = [found.rates([1], [0], 0.1)["at"][0]["forward"]["log_steady_state_rate"] for found in (cluster, again)]
    assert rates[1] == pytest.approx(rates[0], abs=1e-4)


def test_the_tree_in_other_forms(cluster):
    nodes = cluster.tree.nodes
    assert (nodes.minimum[:4] == np.arange(4)).all() and nodes.rows == 7
    assert "digraph" in cluster.tree.dot() or "graph" in cluster.tree.dot()
    assert cluster.tree.to_dict() and cluster.newick().count(",") == 3
    heights = cluster.tree.heights()
    assert (heights == heights.T).all()
    # Of three heights the two largest are equal.
    for a, b, c in [(0, 1, 2), (0, 2, 3), (1, 2, 3)]:
        low, middle, high = sorted([heights[a, b], heights[b, c], heights[a, c]])
        assert middle == high


def test_diversity_of_two_sets(grasps, tmp_path):
    shipped = ls.Grasps.read(Path(__file__).parents[2] / "data/grasps.parquet")
    # Grasps that are all near one, where they are densest, are less diverse than as many from everywhere.
    apart = np.linalg.norm(shipped.poses[:, None] - shipped.poses[None], axis=2)
    near = np.argsort(apart[np.argmin(np.sort(apart, axis=1)[:, 40])])[:40]
    told = ls.diversity(shipped[::10], shipped[near], resamplings=50, out=tmp_path / "told")
    contacts = next(measure for measure in told["measures"] if measure["of"] == "contacts")
    (many, *_), (few, *_) = contacts["sets"]
    assert many["value"] > few["value"] > 1
    assert told["names"] == ["set_1.parquet", "set_2.parquet"]
    assert (tmp_path / "told.md").is_file()
    with pytest.raises(ls.InputError, match="at least 30"):
        ls.diversity(grasps, grasps)


def test_sets_are_judged(grasps, tmp_path):
    told = ls.judge(grasps[:2], tests=["drop"], measures=["q1"], out=tmp_path / "told")
    [found] = told["sets"]
    assert found["grasps"] == 2 and 0 <= found["tests"][0]["holds"] <= 1
    assert (tmp_path / "told.csv").read_text().count("\n") == 3
    with pytest.raises(ls.InputError, match="--tests fall"):
        ls.judge(grasps, tests=["fall"])


def test_files_of_grasps_are_joined(tmp_path):
    shipped = ls.Grasps.read(Path(__file__).parents[2] / "data/grasps.parquet")
    both = ls.join(shipped[:3], shipped[3:5], out=tmp_path / "both.parquet")
    assert list(both.id) == [0, 1, 2, 3, 4]
    assert np.array_equal(both.poses, shipped[:5].poses)
    assert list(both.column("source"))[3].startswith(f"set_2.parquet {shipped.id[3]}")
    assert (tmp_path / "both.parquet").is_file()
    with pytest.raises(ls.InputError, match="two or more"):
        ls.join(shipped)


@ONE
def test_a_landscape_grows(grasps, mapped, tmp_path, line):
    grown = grasps.build(tmp_path / "grown.landscape", onto=mapped)
    held = grown.grasps
    assert held is not None and list(held.id) == list(grasps.id)
    assert np.array_equal(held.poses, grasps.poses)
    assert grown.manifest["onto"]["name"] == mapped.folder.name
    assert sorted(np.concatenate(grown.minima["members"])) == sorted(grasps.id)
    assert set(mapped.minima.energy) <= set(grown.minima.energy)
    assert ls.explore("muller-brown").grasps is None
    with pytest.raises(ls.InputError, match="contains all these grasps already"):
        grasps[:4].build(onto=mapped)
    more = grasps.build(onto=grown, connect=("m1", 0))
    assert more.manifest["findings"]["growth"]["connected"]["searches"] == 40
    with pytest.raises(ls.InputError, match="--connect m99: there are"):
        grasps.build(onto=grown, connect=(0, 99))
    # The command line makes the same bytes.
    grasps.write(tmp_path / "grasps.parquet")
    mapped.save(tmp_path / mapped.folder.name)
    words = ("--onto", mapped.folder.name, "--no-report", "-q", "-o", "line.landscape")
    line("build", "grasps.parquet", *words, cwd=tmp_path)
    for name in ("minima.parquet", "edges.parquet", "attempts.parquet"):
        assert (tmp_path / "line.landscape" / name).read_bytes() == (grown.folder / name).read_bytes(), name
