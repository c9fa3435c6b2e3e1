"""The tutorials run and write their pictures."""

import subprocess
import sys
from pathlib import Path

import pytest

TUTORIALS = Path(__file__).parents[1] / "tutorials"


def run(name, *arguments):
    done = subprocess.run([sys.executable, TUTORIALS / name, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize(
    ("name", "made", "beginning"),
    [
        ("lennard_jones.py", "lennard_jones.svg", b"<svg"),
        ("two_hands.py", "two_hands.png", b"\x89PNG"),
        ("own_hand_and_object.py", "claw.svg", b"<svg"),
        ("published_grasps.py", "published_grasps.png", b"\x89PNG"),
    ],
)
def test_tutorial(name, made, beginning, tmp_path):
    assert run(name, tmp_path).count("\n") > 2
    picture = (tmp_path / made).read_bytes()
    assert len(picture) > 5000 and beginning in picture[:400]


def test_every_tutorial_is_here():
    assert {file.name for file in TUTORIALS.glob("*.py")} == {
        "lennard_jones.py", "two_hands.py", "own_hand_and_object.py", "published_grasps.py",
    }


def test_published_grasps(test_data, tmp_path):
    folder = test_data / "dexgraspnet"
    file = next((folder / "original_npy").glob("core-mug*.npy"))
    hand = test_data / "hands/shadow_dexgraspnet/shadow_hand_vis.xml"
    told = run("published_grasps.py", tmp_path, file, hand, (folder / "meshes" / file.name).with_suffix(".obj"))
    assert "246 grasps" in told and "at scale 0.06" in told
    assert (tmp_path / "published_grasps.png").stat().st_size > 5000
