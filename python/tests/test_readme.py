"""The blocks of README.md run, one after the other."""

import re
from pathlib import Path


def test_blocks_run():
    text = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    assert len(blocks) == 3
    names: dict = {}
    for block in blocks:
        exec(compile(block, "README.md", "exec"), names)
    assert names["passed"].shape == (4,) and len(names["mine"]) == 4
