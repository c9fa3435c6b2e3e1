"""How the program is started: by the package, and as a program of its own where there is one."""

import os
import sys

import pytest

LINES = {"package": [sys.executable, "-c", "import sys, landscape; sys.exit(landscape.main())"]}
if "LANDSCAPE_PROGRAM" in os.environ:
    LINES["program"] = [os.environ["LANDSCAPE_PROGRAM"]]

#: One of them, where a test takes long: the program of cargo where it is at hand.
ONE = pytest.mark.parametrize("line", list(LINES)[-1:], indirect=True)
