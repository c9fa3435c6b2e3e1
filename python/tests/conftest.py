"""What several tests share: the command line, the browser, data that are not ours to ship."""

import os
import subprocess
from pathlib import Path

import pytest
from lines import LINES

import landscape as ls


@pytest.fixture(scope="session")
def run():
    """Playwright, which runs once at a time."""
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as run:
        yield run


@pytest.fixture(scope="session", params=list(LINES))
def line(request):
    """Runs a command line in the folder ``cwd`` and returns what it prints."""
    def run(*words, cwd):
        done = subprocess.run([*LINES[request.param], *map(str, words)], cwd=cwd, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture(scope="session")
def test_data():
    """Published hands, objects and grasps."""
    if "LANDSCAPE_TEST_DATA" not in os.environ:
        pytest.skip("LANDSCAPE_TEST_DATA is not set")
    return Path(os.environ["LANDSCAPE_TEST_DATA"])


@pytest.fixture(scope="session")
def hand():
    return ls.Hand("human")


@pytest.fixture(scope="session")
def bottle():
    return ls.Object("bottle_round")


@pytest.fixture(scope="session")
def grasps(hand, bottle):
    """Six grasps of the human hand on a bottle, whether they are good or not."""
    return ls.synthesize(hand, bottle, 6, seed=1, keep="all")


@pytest.fixture(scope="session")
def mapped(grasps):
    """The landscape of some of these grasps."""
    return grasps[:4].build(neighbours=1)
