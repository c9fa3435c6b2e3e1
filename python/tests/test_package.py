"""Stubs, types, the command line, and the widget."""

import subprocess
import sys

import pytest

import landscape as ls


def run(*words):
    return subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True)


def test_stubs_are_those_of_the_module():
    pytest.importorskip("mypy")
    done = run("mypy.stubtest", "landscape._native")
    assert done.returncode == 0, done.stdout


def test_types_hold():
    pytest.importorskip("mypy")
    done = run("mypy", "--strict", "--ignore-missing-imports", "-p", "landscape")
    assert done.returncode == 0, done.stdout


def test_command_line():
    assert "human" in ls.command("hands", "list")
    with pytest.raises(ls.InputError, match="unrecognized subcommand"):
        ls.command("no-such-verb")
    line = [sys.executable, "-c", "import sys, landscape; sys.exit(landscape.main())", "--version"]
    assert ls.__version__ in subprocess.run(line, capture_output=True, text=True).stdout


def test_the_page_is_a_widget():
    pytest.importorskip("anywidget")
    page = ls.explore("muller-brown").show()
    assert page.selected == [] and "postMessage" in page.page and page.page.count("sha256-") >= 3
