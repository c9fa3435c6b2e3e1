"""The tutorials run and write their pictures."""

import subprocess
import sys
from pathlib import Path

import pytest

TUTORIALS = Path(__file__).parents[1] / "tutorials"


@pytest.mark.parametrize(
    ("name", "made"), [("lennard_jones.py", "lennard_jones.svg"), ("two_hands.py", "human.grasps.html")]
)
def test_tutorial(name, made, tmp_path):
    done = subprocess.run([sys.executable, TUTORIALS / name, tmp_path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / made).stat().st_size > 1000
