"""A file of grasps that was filtered and saved by pandas, polars, DuckDB or pyarrow is still a file of grasps."""

import json
import subprocess

import pytest
from lines import LINES

ROWS = 5
LINE = LINES.get("program") or LINES["package"]


def filtered_by_pandas(source, target):
    pandas = pytest.importorskip("pandas")
    frame = pandas.read_parquet(source)
    frame = frame[frame.energy <= frame.energy.sort_values().iloc[ROWS - 1]]
    frame.to_parquet(target)


def filtered_by_polars(source, target):
    polars = pytest.importorskip("polars")
    polars.read_parquet(source).sort("energy").head(ROWS).write_parquet(target)


def filtered_by_duckdb(source, target):
    duckdb = pytest.importorskip("duckdb")
    duckdb.sql(f"copy (select * from '{source}' order by energy limit {ROWS}) to '{target}' (format parquet)")


def filtered_by_pyarrow(source, target):
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(source)
    parquet.write_table(table.sort_by("energy").slice(0, ROWS), target)


TOOLS = {
    "pandas": (filtered_by_pandas, True),
    "pyarrow": (filtered_by_pyarrow, True),
    "polars": (filtered_by_polars, False),
    "duckdb": (filtered_by_duckdb, False),
}


def run(*words, folder):
    return subprocess.run([*LINE, *words], cwd=folder, capture_output=True, text=True)


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    folder = tmp_path_factory.mktemp("grasps")
    done = run(
        *"synth --object box -n 8 --steps 1 --keep all --seed 1 -q -o g.parquet".split(), folder=folder
    )
    assert done.returncode == 0, done.stderr
    return folder / "g.parquet"


@pytest.mark.parametrize("tool", TOOLS)
def test_a_filtered_file_can_be_used(tool, source, tmp_path):
    work, keeps_metadata = TOOLS[tool]
    work(source, tmp_path / "few.parquet")
    verbs = [["inspect", "few.parquet", "--json"], ["label", "few.parquet", "-q"], ["build", "few.parquet", "--first", "2", "-q"]]
    for verb in verbs:
        done = run(*verb, folder=tmp_path)
        assert done.returncode == 0, done.stderr
        if verb[0] == "inspect":
            assert len(json.loads(done.stdout)["grasps"]) == ROWS
        if keeps_metadata:
            assert "warning" not in done.stderr, done.stderr
        elif verb[0] == "inspect":
            # The names are those of a hand and an object that come with the program, and the columns tell the energy.
            for words in ["hand `human`", "object `box`", "the default one is used"]:
                assert words in done.stderr, done.stderr


def test_without_known_names_a_sentence_asks_for_hand_and_object(source, tmp_path):
    polars = pytest.importorskip("polars")
    frame = polars.read_parquet(source).with_columns(object=polars.lit("my_box"))
    frame.write_parquet(tmp_path / "mine.parquet")
    done = run("inspect", "mine.parquet", "--json", folder=tmp_path)
    assert done.returncode == 1 and "--object" in done.stderr and "`my_box`" in done.stderr, done.stderr
    done = run("inspect", "mine.parquet", "--json", "--object", "box", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert len(json.loads(done.stdout)["grasps"]) == frame.height


@pytest.mark.parametrize("codec", ["none", "snappy", "zstd", "lz4", "gzip", "brotli"])
def test_every_codec_is_read(codec, source, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    parquet.write_table(parquet.read_table(source), tmp_path / "g.parquet", compression=codec)
    told = parquet.read_metadata(tmp_path / "g.parquet").row_group(0).column(0).compression
    assert told.lower() == {"none": "uncompressed"}.get(codec, codec)
    packed, plain = (run("inspect", name, "--json", "-q", folder=tmp_path) for name in ["g.parquet", str(source)])
    assert packed.returncode == 0, packed.stderr
    assert packed.stdout == plain.stdout


def test_pandas_keeps_the_metadata_as_attributes(source):
    pandas = pytest.importorskip("pandas")
    about = pandas.read_parquet(source).attrs["landscape"]
    assert about["hands"][0]["name"] == "human"
    assert about["objects"][0]["name"] == "box"
