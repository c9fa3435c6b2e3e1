"""Energy landscapes of functions: spaces, searches, maps, descents."""

from __future__ import annotations

import math
import shlex
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._call import Folder, StrPath, command, flags, wanted
from ._errors import InputError
from ._landscape import Landscape

Floats = NDArray[np.float64]

#: A function of a point, shape (n,), that returns its energy and the derivative along each coordinate, shape (n,).
EnergyFunction = Callable[[Floats], tuple[Any, Any]]


@dataclass(frozen=True)
class Euclidean:
    """Numbers in a flat space. Without ``n``, as many as the box has sides."""

    n: int | None = None


@dataclass(frozen=True)
class Torus:
    """Angles in radians, which wrap."""

    n: int


@dataclass(frozen=True)
class Periodic:
    """Numbers that wrap: each with the length of its side of the box as its period."""

    n: int | None = None


@dataclass(frozen=True)
class Box:
    """Numbers that never leave the box: a minimum may lie on a face, an edge or a corner of it."""

    n: int | None = None


@dataclass(frozen=True)
class Rotations:
    """A unit quaternion w, x, y, z. The gradient has three numbers, by rotation about each of the body's own axes.

    The function is asked at unit quaternions only; points that you give are scaled to length 1.
    """


@dataclass(frozen=True)
class Atoms:
    """Positions x, y, z of ``n`` atoms: 3 n coordinates. Moved, turned, mirrored and renumbered copies are one point.

    ``elements``: the element of each atom, such as ``("Ar", "Ar", "Kr")``; only atoms of one element are renumbered. Without it
    all atoms are equal. Point groups know the elements; masses are 1 everywhere.
    """

    n: int
    elements: Sequence[str] | None = None


Space = Union[Euclidean, Torus, Periodic, Box, Rotations, Atoms]

_KINDS: dict[type, str] = {
    Euclidean: "flat", Torus: "angles", Periodic: "periodic", Box: "box", Rotations: "rotation", Atoms: "atoms",
}


class Descents(NamedTuple):
    """Ends of descents, row by row."""

    x: Floats
    """Last points, shape (k, n)."""
    energy: Floats
    """Energies there, shape (k,)."""
    gradient_norm: Floats
    """Norms of the gradient there, shape (k,)."""
    evaluations: NDArray[np.uint64]
    """Evaluations spent, shape (k,)."""
    converged: NDArray[np.bool_]
    """Whether the tolerance was met, shape (k,)."""


def _kind(space: Space) -> str:
    """The coordinates of a space as in files."""
    name = _KINDS[type(space)]
    if not isinstance(space, Atoms) or space.elements is None:
        return name
    elements = [str(element) for element in space.elements]
    if len(elements) != space.n:
        raise InputError(f"elements: there are {len(elements)} of them, but {space.n} atoms")
    if not all(element and element == "".join(element.split()) for element in elements):
        raise InputError(f"elements {elements}: names without blanks are needed")
    return " ".join([name, *elements]) if len(set(elements)) > 1 else name


def _count(space: Space) -> int | None:
    if isinstance(space, Atoms):
        return 3 * space.n
    return 4 if isinstance(space, Rotations) else space.n


def _ends(space: Space, box: Any, points: ArrayLike | None) -> tuple[list[float], list[float]]:
    """Low and high ends of the box, one number for each coordinate."""
    count = _count(space)
    if box is None:
        if isinstance(space, Torus):
            box = (-math.pi, math.pi)
        elif isinstance(space, Rotations):
            box = (-1.0, 1.0)
        elif points is not None and np.size(points) and not isinstance(space, (Periodic, Box)):
            given = np.atleast_2d(np.asarray(points, dtype=np.float64))
            low, high = given.min(axis=0), given.max(axis=0)
            side = np.maximum(high - low, (high - low).max() or 1.0)
            return (low - 0.1 * side).tolist(), (high + 0.1 * side).tolist()
        else:
            raise InputError("box=(low, high) is needed: the region from which random starts are drawn")
    try:
        low, high = (np.asarray(end, dtype=np.float64) for end in box)
    except (TypeError, ValueError):
        raise InputError(f"box {box!r}: two numbers or two arrays are needed, (low, high)") from None
    if count is None:
        width = 0 if points is None else np.atleast_2d(np.asarray(points)).shape[1]
        count = max(low.size, high.size, width)
    for name, end in (("low", low), ("high", high)):
        if end.ndim > 1 or end.size not in (1, count):
            raise InputError(f"box: {name} has {end.size} numbers, but the space has {count} coordinates")
    return np.broadcast_to(low, (count,)).tolist(), np.broadcast_to(high, (count,)).tolist()


def _name(function: Any) -> str:
    name = getattr(function, "__name__", None) or type(function).__name__
    return str(name).strip("<>")


def _threads(wanted: int | None) -> int:
    """Threads that call a function: 0 is one for each core."""
    if wanted is None:
        lock = getattr(sys, "_is_gil_enabled", lambda: True)
        return 1 if lock() else 0
    if wanted < 1:
        raise InputError(f"threads {wanted}: at least one is needed")
    return wanted


def _surface(
    function: EnergyFunction, space: Space | None, box: Any, points: ArrayLike | None, hessian: Any, batch: bool, name: str | None,
    threads: int | None,
) -> tuple[_native.Surface, Space, tuple[list[float], list[float]]]:
    if not callable(function):
        raise InputError(f"a function of a point is needed, not {type(function).__name__}")
    chosen = space if space is not None else getattr(function, "space", None) or Euclidean()
    low, high = _ends(chosen, box, points)
    made = _native.Surface(function, hessian, batch, name or _name(function), _kind(chosen), low, high, _threads(threads))
    return made, chosen, (low, high)


def _search(out: Path, told: str, **given: Any) -> dict[str, Any]:
    usual: dict[str, Any] = {
        "seed": 0, "check_gradient": True, "quiet": True, "patience": None, "searches": None, "search": "auto", "lowest": None,
        "budget_s": None, "group_barrier": None, "neighbours": None,
    }
    return {**usual, **given, "out": out, "command": told}


def explore(
    function: EnergyFunction | str,
    space: Space | None = None,
    *,
    box: tuple[ArrayLike, ArrayLike] | None = None,
    seed: int = 0,
    out: StrPath | None = None,
    hessian: Callable[[Floats], Any] | None = None,
    batch: bool = False,
    known: ArrayLike | None = None,
    search: str = "auto",
    lowest: int | None = None,
    patience: int | None = None,
    searches: int | None = None,
    budget_s: float | None = None,
    group_barrier: float | None = None,
    check_gradient: bool = True,
    name: str | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> Landscape:
    """All minima and saddles of a function, and the landscape that they make.

    Parameters
    ----------
    function
        Takes a point, a new array of shape (n,), and returns (energy, gradient); +inf means a point outside the domain. It
        must depend on the point alone. It is not called from the main thread. Or a model of ``landscape surface`` by name,
        such as ``"lj 7"``.
    space
        ``Euclidean()`` (the default), ``Torus(n)``, ``Periodic()``, ``Box()``, ``Rotations()`` or ``Atoms(n)``.
    box
        Low and high ends of the region of random starts: two numbers, or two arrays of shape (n,).
    seed
        Seed of all random draws.
    out
        The folder to write; by default a temporary one, which vanishes with the landscape.
    hessian
        A function of a point that returns the second derivatives, shape (n, n).
    batch
        Whether ``function`` takes many points, shape (k, n), and returns energies (k,) and gradients (k, n). Hessians are then
        made of one call.
    known
        Points from which the search begins besides random ones, shape (k, n).
    search, lowest
        ``"all"``, ``"lowest"`` (the ``lowest`` minima and the ways between them), or ``"auto"``.
    patience, searches, budget_s
        When the search ends: searches without news for every point found, searches in all, seconds. With ``budget_s``
        alone, the number of searches has no limit. A search ends between batches of 32 searches only, so that a slow function
        may take longer than ``budget_s``.
    check_gradient
        Whether to compare the gradient with differences of the energy first.
    name
        Name of the surface in files; by default that of the function.
    threads
        Number of threads that call ``function``: by default one, or one for each core where Python is free-threaded and has
        no global lock. The result is the same. A function that changes what it shares between calls needs one, or a lock.

    Raises
    ------
    GradientError
        If the gradient is not the derivative of the energy; with the numbers.
    EnergyError
        If the function returns NaN or a wrong shape; with the point.
    NothingFoundError
        If no minimum was found.

    Any exception of the function ends the search and is raised with its traceback. Ctrl-C works within a second.
    """
    if search not in ("auto", "all", "lowest"):
        raise InputError(f"search {search!r}: the searches are 'auto', 'all' and 'lowest'")
    if budget_s is not None and not (0 < budget_s < 1e9):
        raise InputError(f"budget_s {budget_s}: a time in seconds is needed")
    keeps = None if out is not None else Folder()
    target = Path(out) if keeps is None else keeps / "surface.landscape"  # type: ignore[arg-type]
    if isinstance(function, str):
        words = flags(
            seed=seed or None, search=None if search == "auto" else search, lowest=lowest, patience=patience,
            searches=searches, budget=None if budget_s is None else f"{budget_s}s", group_barrier=group_barrier, threads=threads, no_report=True,
        )
        command("surface", *shlex.split(function), *words, "--quiet", "--output", target, progress=progress)
        return Landscape(target, _keeps=keeps)
    surface, chosen, (low, _) = _surface(function, space, box, None, hessian, batch, name, threads)
    told = f"landscape.explore({name or _name(function)}, {chosen!r}, box={box!r}, seed={seed}) in Python"
    starts = np.empty((0, len(low))) if known is None else known
    surface.explore(starts, _search(
        target, told, seed=seed, check_gradient=check_gradient, quiet=not wanted(progress), patience=patience, searches=searches,
        search=search, lowest=lowest, budget_s=budget_s, group_barrier=group_barrier,
    ))
    return Landscape(target, _keeps=keeps)


def map(
    function: EnergyFunction,
    minima: ArrayLike,
    space: Space | None = None,
    *,
    box: tuple[ArrayLike, ArrayLike] | None = None,
    seed: int = 0,
    out: StrPath | None = None,
    neighbours: int | None = None,
    group_barrier: float | None = None,
    check_gradient: bool = True,
    name: str | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> Landscape:
    """The landscape between minima of a function, from points near them: descents, attraction–diffusion and relaxed paths.

    Parameters
    ----------
    function, space, seed, out, check_gradient, name, threads
        As in :func:`explore`.
    minima
        Points from which descents lead to the minima, shape (k, n).
    box
        The region in which the gradient is checked; by default around the points.
    neighbours
        Number of nearest minima to which each minimum is connected.

    Raises
    ------
    NothingFoundError
        If the descents end at fewer than two minima.
    """
    keeps = None if out is not None else Folder()
    target = Path(out) if keeps is None else keeps / "surface.landscape"  # type: ignore[arg-type]
    surface, chosen, _ = _surface(function, space, box, minima, None, False, name, threads)
    told = f"landscape.map({name or _name(function)}, {np.shape(minima)} points, {chosen!r}, seed={seed}) in Python"
    surface.map(minima, _search(
        target, told, seed=seed, check_gradient=check_gradient, quiet=not wanted(progress), neighbours=neighbours,
        group_barrier=group_barrier,
    ))
    return Landscape(target, _keeps=keeps)


def quench(
    function: EnergyFunction, starts: ArrayLike, space: Space | None = None, *, gradient_tolerance: float | None = None,
    box: tuple[ArrayLike, ArrayLike] | None = None, threads: int | None = None,
) -> Descents:
    """Descends from each of ``starts``, shape (k, n), to a minimum by L-BFGS. ``gradient_tolerance``: energy per length; by
    default measured on the surface."""
    surface, _, _ = _surface(function, space, box, starts, None, False, None, threads)
    return Descents(*surface.quench(starts, gradient_tolerance))


def evaluate(
    function: EnergyFunction, points: ArrayLike, space: Space | None = None, *, batch: bool = False,
    box: tuple[ArrayLike, ArrayLike] | None = None, threads: int | None = None,
) -> tuple[Floats, Floats]:
    """Energies (k,) and gradients (k, tangents) at ``points``, shape (k, n), as a search gets them, with all its checks."""
    surface, _, _ = _surface(function, space, box, points, None, batch, None, threads)
    return surface.evaluate(points)


class AseEnergy:
    """The energy of an ASE calculator as a function: positions (Å), shape (3 n,), to energy (eV) and gradient (eV/Å).

    Calls take turns, because a calculator keeps its last result.
    """

    def __init__(self, atoms: Any, calculator: Any) -> None:
        self.atoms: Any = atoms.copy()
        self.atoms.calc = calculator
        self.space: Atoms = Atoms(len(atoms), tuple(atoms.get_chemical_symbols()))
        self.__name__: str = type(calculator).__name__
        self._turn = threading.Lock()

    def __call__(self, x: Floats) -> tuple[float, Floats]:
        with self._turn:
            self.atoms.set_positions(x.reshape(-1, 3))
            energy = float(self.atoms.get_potential_energy())
            return energy, -np.asarray(self.atoms.get_forces(), dtype=np.float64).ravel()


def from_ase(atoms: Any, calculator: Any) -> AseEnergy:
    """The energy of ``ase.Atoms`` with a calculator, for :func:`explore`, :func:`map` and :func:`quench`.

    Its space is ``Atoms`` with the elements of the atoms: copies with equal atoms renumbered are one point. The atoms must be
    free and without a periodic cell, because moved and turned copies are one point, too.

    Raises
    ------
    InputError
        If atoms are held by constraints, or the cell is periodic.
    """
    if atoms.get_pbc().any():
        raise InputError("atoms in a periodic cell: keep one atom fixed and write a function on Periodic()")
    if len(atoms.constraints):
        raise InputError("atoms with constraints: write a function of the free coordinates on Euclidean(n)")
    return AseEnergy(atoms, calculator)
