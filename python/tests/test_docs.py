"""The Python blocks of README.md and of docs/ run."""

import json
import pickle
import re
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest

import landscape as ls

ROOT = Path(__file__).parents[2]


def blocks(file):
    return re.findall(r"```python\n(.*?)```", (ROOT / file).read_text(encoding="utf-8"), flags=re.DOTALL)


def test_every_block_has_a_test():
    counts = {
        str(file.relative_to(ROOT)): len(blocks(file))
        for file in [ROOT / "README.md", ROOT / "python/README.md", *(ROOT / "docs").rglob("*.md")]
    }
    assert {file for file, count in counts.items() if count} == {
        "README.md", "python/README.md", "docs/external_energy.md", "docs/mano.md", "docs/neural_objects.md",
        "docs/roadmap.md",
    }


def test_readme_of_the_project():
    names: dict = {}
    (block,) = blocks("README.md")
    exec(compile(block, "README.md", "exec"), names)
    assert names["grasps"].joints.shape[1] == 22


def test_readme():
    names: dict = {}
    for block in blocks("python/README.md"):
        exec(compile(block, "README.md", "exec"), names)
    assert names["passed"].shape == (4,) and len(names["mine"]) == 4
    assert names["page"].selected == ["m0", "m3"]


@pytest.mark.parametrize("loop", blocks("docs/external_energy.md"))
def test_loops_of_external_energies(loop, tmp_path):
    """In a program of its own, which the command line then maps."""
    program = tmp_path / "bowls.py"
    program.write_text(f"""
import json, struct, sys
import numpy
n = 2
def energy_and_gradient(x, y):
    return x * x + (y * y - 1) ** 2, [2 * x, 4 * y * (y * y - 1)]
def energies_and_gradients(points):
    told = [energy_and_gradient(*point) for point in points]
    return [energy for energy, _ in told], [gradient for _, gradient in told]
{loop}""")
    protocol = "json" if "json.loads" in loop else "batch"
    out = tmp_path / "bowls.landscape"
    ls.command(
        "surface", f"--command={sys.executable} {program}", f"--protocol={protocol}", "--region=-1:1,-2:2", "--no-report",
        "--quiet", "-o", out,
    )
    found = ls.load(out)
    assert found.minima.rows == 2 and found.tree.merge_height(0, 1) == pytest.approx(1.0, abs=1e-6)


def test_export_of_mano(tmp_path, monkeypatch):
    sparse = pytest.importorskip("scipy.sparse")
    (block,) = blocks("docs/mano.md")
    keys = ["v_template", "f", "shapedirs", "posedirs", "weights", "kintree_table", "hands_components", "hands_mean", "hands_coeffs"]
    model = {key: np.random.default_rng(len(key)).normal(size=(3, 4)) for key in keys}
    regressor = np.eye(5)
    (tmp_path / "MANO_RIGHT.pkl").write_bytes(pickle.dumps({**model, "J_regressor": sparse.csc_matrix(regressor), "bs": "lbs"}))
    monkeypatch.setattr(sys, "argv", ["export.py", str(tmp_path / "MANO_RIGHT.pkl"), str(tmp_path / "mano_right.npz")])
    exec(compile(block, "mano.md", "exec"), {})
    written = np.load(tmp_path / "mano_right.npz")
    assert sorted(written) == sorted([*keys, "J_regressor"])
    assert all((written[key] == model[key]).all() for key in keys) and (written["J_regressor"] == regressor).all()


def test_a_road_map_is_read(mapped, tmp_path, monkeypatch, capsys):
    """The block prints the seconds of each posture of a way, whose first is held until the hand is closed, and its joints."""
    mapped.save(tmp_path / "grasps.landscape")
    monkeypatch.chdir(tmp_path)
    ls.command("export", "grasps.landscape", "roadmap", "--quiet", "-o", "grasps.roadmap.json")
    (block,) = blocks("docs/roadmap.md")
    exec(compile(block, "roadmap.md", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    seconds = [float(line.split(" ", 1)[0]) for line in lines]
    assert seconds[0] == pytest.approx(0.4) and seconds == sorted(seconds) and seconds[-1] > 0.4
    assert all(len(json.loads(line.split(" ", 1)[1])) == mapped.grasps.joints.shape[1] for line in lines)


class Tensor(np.ndarray):
    """Enough of torch's tensor for the block, which is run without torch where there is none."""

    def contiguous(self):
        return np.ascontiguousarray(self)


def test_conversion_of_a_torch_checkpoint(tmp_path, monkeypatch):
    """A decoder of the octahedron |x| + |y| + |z| = 0.6 becomes an object of that size."""
    numpy_files = pytest.importorskip("safetensors.numpy")
    (block,) = blocks("docs/neural_objects.md")
    # Inputs: one number of the code, which is ignored, then x, y, z. Rectified halves of each add up to its size.
    halves = np.zeros((6, 4))
    for axis in range(3):
        halves[2 * axis, 1 + axis], halves[2 * axis + 1, 1 + axis] = 1.0, -1.0
    weights = {"lin0.weight": halves, "lin0.bias": np.zeros(6), "lin1.weight": np.ones((1, 6)), "lin1.bias": np.array([-0.6])}
    state = {f"module.{name}": value.astype(np.float32).view(Tensor) for name, value in weights.items()}
    files = {
        "model.pth": {"model_state_dict": state},
        "codes.pth": {"latent_codes": {"weight": np.zeros((2, 1), np.float32).view(Tensor)}},
    }

    def load(path, map_location, weights_only):
        assert weights_only and map_location == "cpu"
        return files[Path(path).name]

    torch = types.ModuleType("torch")
    torch.load = load
    safetensors_torch = types.ModuleType("safetensors.torch")
    safetensors_torch.save_file = numpy_files.save_file
    monkeypatch.setitem(sys.modules, "torch", torch)
    monkeypatch.setitem(sys.modules, "safetensors.torch", safetensors_torch)
    monkeypatch.setattr(sys, "argv", ["convert.py", "model.pth", "codes.pth", str(tmp_path / "model.safetensors")])
    exec(compile(block, "neural_objects.md", "exec"), {})
    (tmp_path / "specs.json").write_text(json.dumps({
        "CodeLength": 1,
        "NetworkSpecs": {"dims": [6], "latent_in": [], "norm_layers": [], "weight_norm": False, "xyz_in_all": False, "use_tanh": False},
    }))
    baked = tmp_path / "octahedron.obj"
    ls.command("objects", "bake", tmp_path / "model.safetensors", "--code", 1, "--scale", 0.1, "--cells", 48, "--quiet", "-o", baked)
    assert abs(ls.Object(baked).vertices).max(axis=0) == pytest.approx([0.06] * 3, abs=4e-3)
