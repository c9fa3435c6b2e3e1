"""Files written from Python are, byte for byte, those of the command line: of the package and of the program of cargo."""

from pathlib import Path

import pytest
from lines import ONE

import landscape as ls

GRASPS = Path(__file__).parents[2] / "data/grasps.parquet"


@pytest.fixture(scope="module")
def made(tmp_path_factory, line):
    """Grasps of Python and of the command line."""
    folder = tmp_path_factory.mktemp("grasps")
    grasps = ls.synthesize(ls.Hand("human"), ls.Object("bottle_round"), 6, seed=1, keep="all", out=folder / "python.parquet")
    line("synth", "--object", "bottle_round", "-n", 6, "--seed", 1, "--keep", "all", "-q", "-o", "line.parquet", cwd=folder)
    return folder, grasps


def test_synthesis_gives_the_bytes_of_the_command_line(made):
    folder, grasps = made
    assert (folder / "python.parquet").read_bytes() == (folder / "line.parquet").read_bytes()


def test_labels_give_the_bytes_of_the_command_line(made, line):
    folder, _ = made
    ls.Grasps.read(folder / "line.parquet").label(out=folder / "labelled.python.parquet")
    line("label", "line.parquet", "-q", "-o", "labelled.line.parquet", cwd=folder)
    assert (folder / "labelled.python.parquet").read_bytes() == (folder / "labelled.line.parquet").read_bytes()


@ONE
def test_build_gives_the_bytes_of_the_command_line(made, line):
    folder, _ = made
    found = ls.Grasps.read(folder / "line.parquet").build(folder / "python.landscape", first=6, neighbours=1)
    words = ("--first", 6, "--neighbours", 1, "--no-report", "-q", "-o", "line.landscape")
    line("build", "line.parquet", *words, cwd=folder)
    names = sorted(path.name for path in (folder / "line.landscape").iterdir())
    assert "minima.parquet" in names
    assert names == sorted(path.name for path in found.folder.iterdir())
    for name in names:
        # The only file with times.
        if name != "timings.json":
            same = (found.folder / name).read_bytes() == (folder / "line.landscape" / name).read_bytes()
            assert same, name


def test_labellers_have_the_bytes_of_the_command_line(made, line):
    folder, _ = made
    rows = [f"{number},{('Ring', 'Tripod')[number % 2]}" for number in ls.Grasps.read(GRASPS).id[:30]]
    (folder / "labels.csv").write_text("\n".join(["id,label", *rows]) + "\n")
    ls.learn(GRASPS, folder / "python.labeller", labels=folder / "labels.csv")
    line("label", "--learn", GRASPS, "--from", "labels.csv", "-q", "-o", "line.labeller", cwd=folder)
    assert (folder / "python.labeller").read_bytes() == (folder / "line.labeller").read_bytes()
    line("label", "line.parquet", "--by", "python.labeller", "-q", "-o", "named.line.parquet", cwd=folder)
    named = ls.Grasps.read(folder / "line.parquet").label(by=folder / "python.labeller", out=folder / "named.python.parquet")
    assert len(named) == 6
    assert (folder / "named.python.parquet").read_bytes() == (folder / "named.line.parquet").read_bytes()
