"""How diverse a population of grasps is: synthesis of grasps, energy landscapes, disconnectivity graphs.

Grasps: :class:`Hand`, :class:`Object`, :func:`synthesize`, :class:`Grasps`, :func:`learn`, :class:`Energy`, :func:`build`.
Functions of your own: :func:`explore`, :func:`map`, :func:`quench`. Landscapes: :class:`Landscape`, :func:`load`. The command
line: :func:`command`.
"""

from ._call import command, main
from ._errors import EnergyError, GradientError, InputError, InternalError, LandscapeError, NothingFoundError
from ._grasps import Energy, Evaluation, Grasps, Labeller, import_grasps, join, learn, synthesize
from ._hands import Hand, Object
from ._landscape import (
    Coverage, Difference, Landscape, MinimaxPath, Tree, build, diversity, import_landscape, judge, load,
)
from ._native import HAND_NAMES, OBJECT_NAMES, __version__
from ._surfaces import (
    Atoms, Box, Descents, Euclidean, FixedFrame, Periodic, Rotations, Torus, evaluate, explore, from_ase, map, quench,
)
from ._table import Table

__all__ = [
    "HAND_NAMES", "OBJECT_NAMES", "Atoms", "Box", "Coverage", "Descents", "Difference", "Energy", "EnergyError", "Euclidean",
    "Evaluation", "FixedFrame", "GradientError", "Grasps", "Hand", "InputError", "InternalError", "Labeller", "Landscape",
    "LandscapeError", "MinimaxPath", "NothingFoundError", "Object", "Periodic", "Rotations", "Table", "Torus", "Tree",
    "__version__", "build", "command", "diversity", "evaluate", "explore", "from_ase", "import_grasps", "import_landscape", "judge",
    "join", "learn", "load", "main", "map", "quench", "synthesize",
]
