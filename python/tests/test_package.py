"""Stubs, types, and the command line."""

import importlib.metadata
import os
import subprocess
import sys
from pathlib import Path

import pytest

import landscape as ls


def run(*words, env=None):
    return subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, env=env)


def test_stubs_are_those_of_the_module():
    pytest.importorskip("mypy")
    done = run("mypy.stubtest", "landscape._native")
    assert done.returncode == 0, done.stdout


def test_types_hold():
    pytest.importorskip("mypy")
    done = run("mypy", "--strict", "--ignore-missing-imports", "-p", "landscape")
    assert done.returncode == 0, done.stdout


def test_types_are_complete():
    pytest.importorskip("pyright")
    # Pyright asks the `python` that it finds first.
    places = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = run("pyright", "--verifytypes", "landscape", "--ignoreexternal", env={**os.environ, "PATH": places})
    assert done.returncode == 0 and "Type completeness score: 100%" in done.stdout, done.stdout


def test_command_line():
    assert "human" in ls.command("hands", "list")
    for words in [("--version",), ("synth", "--version")]:
        assert ls.command(*words).endswith(f" {ls.__version__}\n")
    assert "Usage: landscape synth" in ls.command("synth", "--help") == ls.command("help", "synth")
    assert "Commands:" in ls.command()
    line = [sys.executable, "-c", "import sys, landscape; sys.exit(landscape.main())", "--version"]
    assert ls.__version__ in subprocess.run(line, capture_output=True, text=True).stdout


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("no-such-verb",), "unrecognized subcommand 'no-such-verb'"),
        (("synth",), "the following required arguments were not provided: --object <NAME|FILE>"),
        (("synth", "--objct", "x"), "unexpected argument '--objct' found; tip: a similar argument exists: '--object'"),
        (
            ("synth", "--object=box", "--keep=x"),
            "invalid value 'x' for '--keep <KEEP>' [possible values: strict, published, all]",
        ),
        (("synth", "--object=box", "-n=-1"), "invalid value '-1' for '--chains <N>': invalid digit found in string"),
    ],
)
def test_an_error_is_one_sentence(words, sentence):
    with pytest.raises(ls.InputError) as told:
        ls.command(*words)
    assert str(told.value) == sentence


def test_notices_of_all_dependencies_travel_along():
    files = {path.name: path for path in importlib.metadata.files("grasp-landscape")}
    assert "LICENSE-MIT" in files and "LICENSE-APACHE" in files
    notices = files["THIRD_PARTY.txt"].read_text()
    for name in ["Bitstream Vera", "pyo3", "zstd"]:
        assert name in notices, name
