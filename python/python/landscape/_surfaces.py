"""Energy landscapes of functions: spaces, searches, maps, descents."""

from __future__ import annotations

import math
import operator
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
from ._checks import magnitude_or_none, points_of, whole, whole_or_none
from ._errors import InputError
from ._landscape import Landscape

Floats = NDArray[np.float64]

#: A function of a point, shape (n,), that returns its energy and the derivative along each coordinate, shape (n,).
EnergyFunction = Callable[[Floats], tuple[Any, Any]]


class _Numbered:
    """A space with a number ``n`` of coordinates or atoms, which is checked."""

    n: int | None

    def __post_init__(self) -> None:
        object.__setattr__(self, "n", whole_or_none(f"n of {type(self).__name__}", self.n, 1))


@dataclass(frozen=True)
class Euclidean(_Numbered):
    """Numbers in a flat space. ``n``: how many; by default as many as the box has sides.

    ``symmetries``: what leaves the energy as it is, each as the coordinates of the copy, counted from 1 and negated by a minus:
    ``[[2, 1, 3], [-1, -2, 3]]`` exchanges the first two coordinates, and negates both. Copies of a point are one point.
    """

    n: int | None = None
    symmetries: Sequence[Sequence[int]] | None = None


@dataclass(frozen=True)
class Torus(_Numbered):
    """Angles in radians, which wrap. ``n``: how many. ``symmetries``: as of :class:`Euclidean`."""

    n: int
    symmetries: Sequence[Sequence[int]] | None = None


@dataclass(frozen=True)
class Periodic(_Numbered):
    """Numbers that wrap: each with the length of its side of the box as its period. ``n``: as of :class:`Euclidean`."""

    n: int | None = None


@dataclass(frozen=True)
class Box(_Numbered):
    """Numbers that never leave the box: a minimum may lie on a face, an edge or a corner of it. ``n``: as of
    :class:`Euclidean`."""

    n: int | None = None


@dataclass(frozen=True)
class Rotations:
    """A unit quaternion w, x, y, z. The gradient has three numbers, by rotation about each of the body's own axes.

    The function is asked at unit quaternions only; points that you give are scaled to length 1.
    """


@dataclass(frozen=True)
class Atoms(_Numbered):
    """Positions x, y, z of ``n`` atoms: 3 n coordinates. Moved, turned, mirrored and renumbered copies are one point.

    ``n``: how many atoms. ``elements``: the element of each atom, such as ``("Ar", "Ar", "Kr")``; only atoms of one element are
    renumbered. Without it all atoms are equal. Point groups know the elements; masses are 1 everywhere.
    """

    n: int
    elements: Sequence[str] | None = None


@dataclass(frozen=True)
class FixedFrame:
    """Positions x, y, z of atoms among others that stay, such as a surface or a crystal: 3 n coordinates.

    ``elements``: the element of each atom, such as ``("Ar", "Ar")``; configurations in which atoms of one element have changed
    places are one point, moved copies are not. ``periodic``: whether each coordinate wraps, with the length of its side of
    the box as its period.
    """

    elements: Sequence[str]
    periodic: bool = False


Space = Union[Euclidean, Torus, Periodic, Box, Rotations, Atoms, FixedFrame]

_KINDS: dict[type, str] = {
    Euclidean: "flat", Torus: "angles", Periodic: "periodic", Box: "box", Rotations: "rotation", Atoms: "atoms",
    FixedFrame: "flat",
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
    if isinstance(space, (Euclidean, Torus)) and space.symmetries is not None:
        try:
            rows = [" ".join(str(operator.index(number)) for number in row) for row in space.symmetries]
        except TypeError:
            told = f"symmetries {space.symmetries!r}: lists of whole numbers are needed, such as [[2, 1], [-1, -2]]"
            raise InputError(told) from None
        if not rows:
            raise InputError("symmetries: the list is empty; leave it out for an energy without symmetries")
        return f"{name} modulo {', '.join(rows)}"
    if not isinstance(space, (Atoms, FixedFrame)) or space.elements is None:
        return name
    if isinstance(space.elements, str):
        raise InputError(f"elements {space.elements!r}: a list of the element of each atom is needed, such as ['Ar', 'Ar']")
    elements = [str(element) for element in space.elements]
    if isinstance(space, Atoms) and len(elements) != space.n:
        raise InputError(f"elements: there are {len(elements)} of them, but {space.n} atoms")
    if not all(element and element == "".join(element.split()) for element in elements):
        raise InputError(f"elements {elements}: names without blanks are needed")
    if isinstance(space, FixedFrame):
        return " ".join(["periodic" if space.periodic else name, *elements])
    return " ".join([name, *elements]) if len(set(elements)) > 1 else name


def _count(space: Space) -> int | None:
    if isinstance(space, Atoms):
        return 3 * space.n
    if isinstance(space, FixedFrame):
        return 3 * len(space.elements)
    return 4 if isinstance(space, Rotations) else space.n


def _ends(space: Space, box: Any, given: Floats | None) -> tuple[list[float], list[float]]:
    """Low and high ends of the box, one number for each coordinate."""
    count = _count(space)
    if box is None:
        if isinstance(space, Torus):
            box = (-math.pi, math.pi)
        elif isinstance(space, Rotations):
            box = (-1.0, 1.0)
        elif given is not None and given.size and not isinstance(space, (Periodic, Box)) and not getattr(space, "periodic", False):
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
        width = 0 if given is None else given.shape[1]
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
    return whole("threads", wanted, 1, 1024)


def _space(space: Any, function: Any) -> Space:
    """The space that is given, else that of the function, else a flat one."""
    chosen: Any = space if space is not None else getattr(function, "space", None) or Euclidean()
    if type(chosen) not in _KINDS:
        told = f"the class {chosen.__name__}" if isinstance(chosen, type) else repr(chosen)
        raise InputError(f"space: a space such as landscape.Euclidean() is needed, not {told}")
    made: Space = chosen
    return made


def _surface(
    function: EnergyFunction, space: Space | None, box: Any, given: Floats | None, hessian: Any, batch: bool, name: str | None,
    threads: int | None,
) -> tuple[_native.Surface, Space, tuple[list[float], list[float]]]:
    if not callable(function):
        raise InputError(f"a function of a point is needed, not {type(function).__name__}")
    if hessian is not None and not callable(hessian):
        raise InputError(f"hessian: a function of a point is needed, not {type(hessian).__name__}")
    chosen = _space(space, function)
    low, high = _ends(chosen, box, given)
    made = _native.Surface(function, hessian, batch, name or _name(function), _kind(chosen), low, high, _threads(threads))
    return made, chosen, (low, high)


def _search(out: Path, told: str, **given: Any) -> dict[str, Any]:
    usual: dict[str, Any] = {
        "seed": 0, "check_gradient": True, "quiet": True, "patience": None, "searches": None, "search": "auto", "lowest": None,
        "budget_s": None, "family_barrier": None, "neighbours": None,
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
    family_barrier: float | None = None,
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
        ``Euclidean()`` (the default), ``Torus(n)``, ``Periodic()``, ``Box()``, ``Rotations()``, ``Atoms(n)`` or ``FixedFrame(elements)``. A model has
        its own space and box, and takes neither ``known`` nor ``hessian``, ``batch`` and ``name``.
    box
        Low and high ends of the region of random starts, in the unit of the coordinates: two numbers, or two arrays of shape
        (n,).
    seed
        Seed of all random draws.
    out
        The folder to write; by default a temporary one, which vanishes with the landscape.
    hessian
        A function of a point that returns the second derivatives, shape (n, n). It is compared with differences, too.
    batch
        Whether ``function`` takes many points, shape (k, n), and returns energies (k,) and gradients (k, n). Hessians are then
        made of one call; all else asks for one point at a time.
    known
        Points from which the search begins besides random ones, shape (k, n).
    search, lowest
        ``"all"``, ``"lowest"`` (the ``lowest`` minima and the ways between them; D. J. Wales and J. P. K. Doye, J. Phys. Chem.
        A 101, 5111 (1997)), or ``"auto"``, which measures how large the landscape is.
    patience, searches, budget_s
        When the search ends: searches without news for every point found, searches in all, seconds. With ``budget_s``
        alone, the number of searches has no limit. A search ends between batches of 32 searches only, so that a slow function
        may take longer than ``budget_s``.
    family_barrier
        Greatest relative barrier within a family, in units of the energy; by default it is chosen.
    check_gradient
        Whether to compare the gradient with differences of the energy first.
    name
        Name of the surface in files; by default that of the function.
    threads
        Number of threads that call ``function``: by default one, or one for each core where Python is free-threaded and has
        no global lock. The result is the same. A function that changes what it shares between calls needs one, or a lock.
    progress
        Whether to show progress bars; by default if standard error is a terminal.

    Raises
    ------
    InputError
        If an argument is wrong; the sentence names it.
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
    budget_s = magnitude_or_none("budget_s", budget_s)
    if budget_s == 0:
        raise InputError("budget_s 0: a time in seconds is needed")
    limits: dict[str, Any] = {
        "seed": whole("seed", seed), "lowest": whole_or_none("lowest", lowest, 2, 10**6),
        "patience": whole_or_none("patience", patience, 1, 10**9), "searches": whole_or_none("searches", searches, 1, 10**9),
        "family_barrier": magnitude_or_none("family_barrier", family_barrier),
    }
    keeps = None if out is not None else Folder()
    target = Path(out) if keeps is None else keeps / "surface.landscape"  # type: ignore[arg-type]
    if isinstance(function, str):
        for argument, given in [
            ("space", space), ("box", box), ("known", known), ("hessian", hessian), ("batch", batch or None), ("name", name),
        ]:
            if given is not None:
                raise InputError(f"{argument}: the model {function!r} takes none, only a function does")
        budget = None if budget_s is None else f"{budget_s}s"
        words = flags(
            **{**limits, "seed": limits["seed"] or None}, search=None if search == "auto" else search, budget=budget,
            threads=None if threads is None else _threads(threads), no_report=True,
        )
        command("surface", *shlex.split(function), *words, "--quiet", "--output", target, progress=progress)
        return Landscape(target, _keeps=keeps)
    surface, chosen, (low, _) = _surface(function, space, box, None, hessian, batch, name, threads)
    told = f"landscape.explore({name or _name(function)}, {chosen!r}, box={box!r}, seed={limits['seed']}) in Python"
    starts = np.empty((0, len(low))) if known is None else known
    surface.explore(starts, _search(
        target, told, check_gradient=check_gradient, quiet=not wanted(progress), search=search, budget_s=budget_s, **limits,
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
    hessian: Callable[[Floats], Any] | None = None,
    batch: bool = False,
    search: str = "passes",
    neighbours: int | None = None,
    family_barrier: float | None = None,
    check_gradient: bool = True,
    name: str | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> Landscape:
    """The landscape between minima of a function, from points near them: descents, attraction–diffusion and relaxed paths.

    The method is that of :func:`build`.

    Parameters
    ----------
    function, space, seed, out, hessian, batch, family_barrier, check_gradient, name, threads, progress
        As in :func:`explore`. The space cannot be ``Box()``.
    minima
        Points from which descents lead to the minima, shape (k, n).
    search
        How the minima are joined, as in :func:`build`.
    box
        The region in which the gradient is checked, as in :func:`explore`; by default around the points.
    neighbours
        Number of nearest minima to which each minimum is connected.

    Raises
    ------
    InputError, GradientError, EnergyError
        As in :func:`explore`.
    NothingFoundError
        If the descents end at fewer than two minima.
    """
    if search not in ("passes", "adelm"):
        raise InputError(f'search: "passes" or "adelm", not {search!r}')
    seed, neighbours = whole("seed", seed), whole_or_none("neighbours", neighbours, 1)
    family_barrier, starts = magnitude_or_none("family_barrier", family_barrier), points_of("minima", minima)
    keeps = None if out is not None else Folder()
    target = Path(out) if keeps is None else keeps / "surface.landscape"  # type: ignore[arg-type]
    surface, chosen, _ = _surface(function, space, box, starts, hessian, batch, name, threads)
    told = f"landscape.map({name or _name(function)}, {starts.shape} points, {chosen!r}, seed={seed}) in Python"
    surface.map(starts, _search(
        target, told, seed=seed, check_gradient=check_gradient, quiet=not wanted(progress), neighbours=neighbours,
        family_barrier=family_barrier, search=search,
    ))
    return Landscape(target, _keeps=keeps)


def quench(
    function: EnergyFunction, starts: ArrayLike, space: Space | None = None, *, gradient_tolerance: float | None = None,
    batch: bool = False, box: tuple[ArrayLike, ArrayLike] | None = None, check_gradient: bool = True, threads: int | None = None,
) -> Descents:
    """Descends from points to minima by L-BFGS (J. Nocedal, Math. Comput. 35, 773 (1980)).

    Parameters
    ----------
    function, space, batch, check_gradient, threads
        As in :func:`explore`. Descents ask a function with ``batch=True`` at one point at a time.
    starts
        Points from which to descend, shape (k, n).
    gradient_tolerance
        Norm of the gradient at which a descent has converged, energy per length; by default measured on the surface.
    box
        As in :func:`explore`; by default around the points.

    Returns
    -------
    Descents
        A row for each start. One that does not converge is told, and is no error.

    Raises
    ------
    InputError, GradientError, EnergyError
        As in :func:`explore`.
    """
    begun, tolerance = points_of("starts", starts), magnitude_or_none("gradient_tolerance", gradient_tolerance)
    surface, _, _ = _surface(function, space, box, begun, None, batch, None, threads)
    return Descents(*surface.quench(begun, tolerance, check_gradient))


def evaluate(
    function: EnergyFunction, points: ArrayLike, space: Space | None = None, *, batch: bool = False,
    box: tuple[ArrayLike, ArrayLike] | None = None, threads: int | None = None,
) -> tuple[Floats, Floats]:
    """Energies, shape (k,), and gradients, shape (k, tangents), as a search gets them, with all its checks.

    There are as many tangents as coordinates, except on ``Rotations()``, which has three.

    Parameters
    ----------
    function, space, threads
        As in :func:`explore`.
    points
        Points at which to ask, shape (k, n).
    batch
        Whether ``function`` takes many points, as in :func:`explore`. It is then asked at up to 1024 of them at once.
    box
        As in :func:`explore`; by default around the points.

    Raises
    ------
    InputError
        If an argument is wrong; the sentence names it.
    EnergyError
        If the function returns NaN or a wrong shape; with the point.
    """
    asked = points_of("points", points)
    surface, _, _ = _surface(function, space, box, asked, None, batch, None, threads)
    return surface.evaluate(asked)


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
        """The energy (eV) and its gradient (eV/Å), shape (3 n,), at the positions ``x`` (Å), shape (3 n,)."""
        with self._turn:
            self.atoms.set_positions(x.reshape(-1, 3))
            energy = float(self.atoms.get_potential_energy())
            return energy, -np.asarray(self.atoms.get_forces(), dtype=np.float64).ravel()


def from_ase(atoms: Any, calculator: Any) -> AseEnergy:
    """The energy of ``ase.Atoms`` with a calculator, for :func:`explore`, :func:`map` and :func:`quench`.

    Positions are in Å, energies in eV, gradients in eV/Å. ASE: A. H. Larsen et al., J. Phys.: Condens. Matter 29, 273002
    (2017).

    Its space is ``Atoms`` with the elements of the atoms: copies with equal atoms renumbered are one point. The atoms must be
    free and without a periodic cell, because moved and turned copies are one point, too.

    Parameters
    ----------
    atoms
        The ``ase.Atoms``, of which a copy is taken.
    calculator
        A calculator of ASE. It is asked from one thread at a time.

    Raises
    ------
    InputError
        If atoms are held by constraints, or the cell is periodic.
    """
    if atoms.get_pbc().any():
        raise InputError("atoms in a periodic cell: keep one atom fixed and write a function on FixedFrame(elements, periodic=True)")
    if len(atoms.constraints):
        raise InputError("atoms with constraints: write a function of the free atoms on FixedFrame(elements)")
    return AseEnergy(atoms, calculator)
