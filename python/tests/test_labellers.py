"""Labellers that people teach: taught, used, and refused."""

from pathlib import Path

import numpy as np
import pytest

import landscape as ls

#: 437 grasps of one bottle.
GRASPS = Path(__file__).parents[2] / "data/grasps.parquet"


@pytest.fixture(scope="module")
def some():
    """Forty grasps."""
    return ls.Grasps.read(GRASPS)[::11]


@pytest.fixture(scope="module")
def table(some, tmp_path_factory):
    """A table with labels of all of them: a person who says what the rule says."""
    best = some.label().column("label_best")
    rows = [f"{number},{words.split(' (')[0]}" for number, words in zip(some.id, best)]
    file = tmp_path_factory.mktemp("labels") / "labels.csv"
    file.write_text("\n".join(["id,label", *rows]) + "\n")
    return file


@pytest.fixture(scope="module")
def labeller(some, table, tmp_path_factory):
    return ls.learn(some, tmp_path_factory.mktemp("taught") / "my.labeller", labels=table)


def test_a_labeller_says_how_well_it_does(labeller):
    assert labeller.path.is_file() and sum(labeller.labels.values()) == 40 and len(labeller.labels) > 3
    assert labeller.tested_on_left_out == "grasps", "of one object"
    judged = labeller.judged
    assert judged.name == ["category", "cell", "type"] and (judged.rule_share == 1).all()
    assert (judged.labeller_share > judged.commonest_share).all()
    assert judged.gain_interval_share.shape == (3, 2)
    assert set(labeller.certainties.certainty) <= {"likely", "open", "a guess"}
    for name in judged.name:
        own = labeller.certainties.where([other == name for other in labeller.certainties.name])
        assert own.answers.sum() == 40


def test_a_labeller_names_grasps(some, labeller, tmp_path):
    pages = []
    for by in (labeller, labeller.path, str(labeller.path)):
        named = some.label(by=by)
        sources = named.column("label_source")
        assert np.isin(sources, ["labeller", "rule"]).all() and (sources == "labeller").mean() > 0.6
        assert named.metadata["labels"]["labeller"]["labels"] == 40
        pages.append(some.report(tmp_path / "page.html", by=by).read_bytes())
    assert pages[0] == pages[1] == pages[2]
    assert some.label().metadata["labels"]["labeller"] is None


def test_labels_may_stand_in_the_files(some, table, labeller, tmp_path):
    labelled = some.label(labels=table)
    first, second = labelled[:25], labelled[25:].write(tmp_path / "b.parquet")
    both = ls.learn([first, second], tmp_path / "both.labeller")
    assert both.labels == labeller.labels
    again = ls.learn([first, second], tmp_path / "both.labeller")
    assert (again.judged.labeller_share == both.judged.labeller_share).all(), "its own file is replaced"


def test_what_cannot_be_learned_is_refused(some, table, labeller, tmp_path):
    out = tmp_path / "x.labeller"
    with pytest.raises(ls.InputError, match="0 grasps .* at least 30 are needed"):
        ls.learn(some, out)
    with pytest.raises(ls.InputError, match="labels.csv, line 2[0-9]: no grasp has the id"):
        ls.learn(some[:20], out, labels=table)
    with pytest.raises(FileNotFoundError):
        ls.learn([some, tmp_path / "none.parquet"], out)
    assert not out.exists()
    with pytest.raises(ls.InputError, match="labels.csv: this is not a labeller"):
        some.label(by=table)
    out.write_text("mine")
    with pytest.raises(ls.InputError, match="not made by landscape .*--force"):
        ls.learn(some, out, labels=table)
    ls.learn(some, out, labels=table, force=True)
    assert out.read_bytes() == labeller.path.read_bytes()
