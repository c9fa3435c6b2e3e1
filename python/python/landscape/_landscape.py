"""Landscapes: minima, the ways between them, and their tree."""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._call import Folder, StrPath, command, existing, flags
from ._errors import InputError
from ._table import Table

if TYPE_CHECKING:
    from ._grasps import Grasps
    from .widget import Page

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class MinimaxPath:
    """The minimax path between two minima: of all paths, that with the lowest highest point."""

    minima: NDArray[np.int64]
    """The minima along the path, with both ends."""
    coordinates: Floats
    """Its points, shape (points, coordinates). For grasps these are poses as in :attr:`Grasps.poses`."""
    energy: Floats
    """Shape (points,)."""
    length: Floats
    """Length of the path up to each point, shape (points,): metres for grasps."""
    terms: dict[str, Floats]
    """Energy by term, shape (points,) each; empty for an energy without terms."""

    @property
    def poses(self) -> Floats:
        """The same as ``coordinates``."""
        return self.coordinates

    @property
    def top(self) -> int:
        """Index of the highest point."""
        return int(np.argmax(self.energy))

    @property
    def height(self) -> float:
        """Energy of the highest point."""
        return float(self.energy.max())


class Coverage(NamedTuple):
    """How complete a search was."""

    minima: int
    """Minima found."""
    saddles: int
    """Saddles found."""
    searches: int
    """Searches made."""
    sure: float | None
    """Probability that nothing was missed, if it can be told."""
    told: dict[str, Any]
    """All that the search tells of its completeness."""


class Tree:
    """The disconnectivity graph of a landscape. Nodes 0 to n − 1 are the minima; a merge has a larger number than its branches."""

    def __init__(self, native: _native.Folder, folder: Path) -> None:
        self._native, self._folder = native, folder

    @cached_property
    def nodes(self) -> Table:
        """``energy`` (of the minimum, or of the pass), ``parent`` (−1 for a root), ``minimum`` (−1 for a merge) and
        ``evidence`` (``saddle``, ``seam``, ``path`` or ``chain``)."""
        return Table(self._native.nodes())

    def merge_height(self, a: int, b: int) -> float:
        """The lowest height at which two minima are connected: the energy of the lowest pass between them; +inf if they are
        not."""
        height = self._native.minimax(a, b)
        return float("inf") if height is None else height

    minimax = merge_height

    def heights(self) -> Floats:
        """These heights for all pairs, shape (n, n); on the diagonal the energies of the minima."""
        return self._native.heights()

    def newick(self) -> str:
        """The tree in Newick format."""
        return (self._folder / "tree.nwk").read_text(encoding="utf-8")

    def dot(self) -> str:
        """The tree in the language of Graphviz."""
        return (self._folder / "tree.dot").read_text(encoding="utf-8")

    def to_dict(self) -> dict[str, Any]:
        """The tree as in ``tree.json``."""
        made: dict[str, Any] = json.loads((self._folder / "tree.json").read_text(encoding="utf-8"))
        return made


class Difference:
    """What differs between two landscapes."""

    def __init__(self, told: dict[str, Any]) -> None:
        self.told = told
        """All of it, as ``landscape diff --json`` tells it."""

    @property
    def matches(self) -> Table:
        """Corresponding minima: ``before``, ``after``, their energies and their distance."""
        rows = self.told["matches"]
        return Table({
            "before": np.array([row["before"] for row in rows], dtype=np.int64),
            "after": np.array([row["after"] for row in rows], dtype=np.int64),
            "energy_before": np.array([row["energies"][0] for row in rows], dtype=np.float64),
            "energy_after": np.array([row["energies"][1] for row in rows], dtype=np.float64),
            "distance": np.array([row["distance"] for row in rows], dtype=np.float64),
        })

    @property
    def vanished(self) -> list[int]:
        """Minima of the first landscape that the second lacks."""
        return list(self.told["vanished"])

    @property
    def appeared(self) -> list[int]:
        """Minima of the second landscape that the first lacks."""
        return list(self.told["appeared"])

    def to_pandas(self) -> Any:
        """The corresponding minima as a ``pandas.DataFrame``."""
        return self.matches.to_pandas()

    def __repr__(self) -> str:
        return f"{self.matches.rows} minima correspond, {len(self.vanished)} vanished, {len(self.appeared)} appeared"


class Landscape:
    """A landscape folder of ``landscape build``, ``surface`` or ``import``, or of :func:`build`, :func:`explore`, :func:`map`.

    Minima are numbered from 0 by energy.
    """

    def __init__(self, folder: StrPath, *, _keeps: object = None) -> None:
        self.folder: Path = existing(folder)
        """The folder."""
        self._keeps = _keeps
        self._native = _native.Folder(self.folder)

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """How the landscape was made, and its findings: ``landscape.json``."""
        made: dict[str, Any] = json.loads(self._native.manifest())
        return made

    @property
    def summary(self) -> str:
        """The text ``summary.md``."""
        return (self.folder / "summary.md").read_text(encoding="utf-8")

    @cached_property
    def minima(self) -> Table:
        """``energy``, ``coordinates`` (n, d), ``group``, ``members`` (ids of the inputs that descend to it), ``label`` and
        ``choice`` (contact set) of each minimum, lowest first."""
        return Table(self._native.minima())

    @cached_property
    def edges(self) -> Table:
        """The pairs that were tried: ``a``, ``b``, ``height`` (NaN: no path), ``relative_barrier``, ``length``, ``evidence``,
        ``term`` (that rises most), ``way`` (sliding, rolling, regrasping, letting go), ``chain_runs``, ``evaluations``."""
        return Table(self._native.edges())

    @cached_property
    def stationary(self) -> Table:
        """All minima and saddles of a searched surface: ``index`` (0 or 1), ``id``, ``a``, ``b`` (minima that a saddle joins),
        ``energy``, ``coordinates``, ``curvatures``, ``gradient_norm``, ``searches``, ``verdict``. No rows otherwise."""
        return Table(self._native.stationary())

    @property
    def saddles(self) -> Table:
        """The saddles among :attr:`stationary`, lowest first."""
        return self.stationary.where(self.stationary["index"] == 1)

    @cached_property
    def tree(self) -> Tree:
        """The disconnectivity graph."""
        return Tree(self._native, self.folder)

    @property
    def grasps(self) -> Grasps | None:
        """The grasps that were mapped, whose ids are the ``members`` of minima; ``None`` for a landscape of a surface."""
        from ._grasps import Grasps

        file = self.folder / "grasps.parquet"
        return Grasps.read(file) if file.is_file() else None

    @property
    def groups(self) -> NDArray[np.int64]:
        """The group of each minimum, shape (n,): minima that are joined below the group barrier."""
        groups: NDArray[np.int64] = self.minima["group"]
        return groups

    @property
    def group_barrier(self) -> float | None:
        """Greatest relative barrier within a group, in units of the energy."""
        barrier: float | None = self.manifest["group_barrier"]
        return barrier

    @property
    def coverage(self) -> Coverage | None:
        """How complete the search of a surface was; ``None`` for other landscapes."""
        told = self.manifest["findings"].get("coverage")
        if told is None:
            return None
        minima, saddles = (int((self.stationary["index"] == index).sum()) for index in (0, 1))
        return Coverage(minima, saddles, int(told["searches"]), told.get("sure"), told)

    @property
    def unseen_groups(self) -> dict[str, Any] | None:
        """Estimate of groups that the inputs did not show (rarefaction, Chao1), as in ``landscape.json``."""
        told = self.manifest["findings"].get("rarefaction") or {}
        found: dict[str, Any] | None = told.get("groups")
        return found

    def path(self, a: int, b: int, *, terms: bool = True) -> MinimaxPath | None:
        """The minimax path between two minima; ``None`` if none joins them.

        Parameters
        ----------
        a, b
            Numbers of minima, from 0.
        terms
            Whether to compute the energy by term along the path of grasps.
        """
        found = self._native.path(a, b, terms)
        return None if found is None else MinimaxPath(**found)

    def draw_path(self, a: int, b: int, out: StrPath, *, pictures: int | None = None) -> list[Path]:
        """Draws the minimax path between two minima of grasps: ``out`` with the endings ``.png`` and ``.svg`` (pictures of the
        hand over the energy by term) and ``.glb`` (an animation). Returns the three paths.

        ``pictures``: the number of pictures along the path; 8 by default.
        """
        given = flags(pictures=pictures)
        command("inspect", self.folder, "--path", f"m{a}", f"m{b}", *given, "--quiet", "--output", out, progress=False)
        stem = Path(out)
        return [stem.with_name(stem.name + ending) for ending in (".png", ".svg", ".glb")]

    def newick(self) -> str:
        """The tree in Newick format."""
        return self.tree.newick()

    def diff(self, other: Landscape | StrPath, *, within: float | None = None) -> Difference:
        """What differs in ``other``, a landscape of the same hand or the same space.

        ``within``: greatest distance of corresponding minima; by default the tolerance with which the landscapes were made.
        """
        told = command("diff", self.folder, _folder(other), "--json", *flags(within=within), progress=False)
        return Difference(json.loads(told))

    def compare(
        self, other: Landscape | StrPath | None = None, *, out: StrPath | None = None, group_barrier: float | None = None,
        seed: int = 0, progress: bool | None = None,
    ) -> str:
        """Tests how the landscape agrees with the taxonomy of grasps (and which types ``other`` holds); returns the text.

        ``out``: the stem of the files to write; by default none are kept.
        """
        folder = Folder()
        stem = folder / "comparison" if out is None else Path(out)
        words = [] if other is None else [_folder(other)]
        # The text is that of a run that is not quiet.
        return command(
            "compare", self.folder, *words, *flags(group_barrier=group_barrier, seed=seed or None), "--output", stem,
            progress=progress,
        )

    def draw(
        self, out: StrPath, *, lowest: int | None = None, deepest: int | None = None,
        min_members: int | None = None, monotonic: bool = False,
        pick: Sequence[str] | None = None, levels: int | None = None, place_by: str | None = None,
        colour_by: str | None = None, values: StrPath | None = None, examples: int | None = None,
        colour: Literal["category", "power", "spheres"] | None = None, stability: StrPath | None = None,
        group_barrier: float | None = None, seed: int | None = None,
    ) -> Path:
        """Draws the landscape and returns the path.

        Parameters
        ----------
        out
            A folder for all pictures and texts, or a file ending in ``.svg`` or ``.png`` for the disconnectivity graph alone.
        lowest, deepest, min_members, pick, monotonic
            Which minima are drawn.
        levels
            Number of levels at which branches join, as in published disconnectivity graphs.
        place_by, colour_by, values
            Quantities that place or colour the minima, and a CSV file with values of yours.
        colour, stability
            Colours of grasps: differences between their types, or a file of :meth:`Grasps.stability` with what held.
        examples
            Number of rendered grasps below the graph.
        """
        target = Path(out)
        picture = target.suffix if target.suffix in (".svg", ".png") else None
        keeps = Folder()
        folder = target if picture is None else keeps / "view"
        given = flags(
            lowest=lowest, deepest=deepest, min_members=min_members, monotonic=monotonic, pick=None if pick is None else list(pick),
            levels=levels, place_by=place_by, colour_by=colour_by, values=values, examples=examples,
            colour=colour, stability=stability, group_barrier=group_barrier, seed=seed,
        )
        command("draw", self.folder, *given, "--quiet", "--output", folder, progress=False)
        if picture is not None:
            drawn = folder / f"disconnectivity{picture}"
            if not drawn.is_file():
                raise InputError(f"{target}: this landscape has no disconnectivity graph to draw")
            shutil.copyfile(drawn, target)
        return target

    def report(
        self, out: StrPath | None = None, *, other: Landscape | StrPath | None = None, stability: StrPath | None = None,
        progress: bool | None = None,
    ) -> Path:
        """Writes the page on which the landscape is explored in a browser (with ``other``: both face to face) and returns its
        path, by default beside the folder with the ending ``.report.html``."""
        target = self.folder.with_suffix(".report.html") if out is None else Path(out)
        words = [] if other is None else [_folder(other)]
        command(
            "report", self.folder, *words, *flags(stability=stability), "--quiet", "--output", target, progress=progress
        )
        return target

    def show(self, *, height_px: int = 720) -> Page:
        """The page of :meth:`report` as a widget of a notebook; needs ``anywidget``. What is chosen on it is ``selected``."""
        from .widget import Page

        return Page.of(self.report, height_px)

    def thermodynamics(
        self, out: StrPath | None = None, *, temperatures: str | None = None, free_energy_at: float | None = None,
    ) -> dict[str, Any]:
        """Heat capacity, occupation of minima and free energies against temperature, as ``landscape thermodynamics --json``.

        ``temperatures``: ``"LOW:HIGHxN"``, in units of the energy. ``out``: the folder to write; by default none is kept.
        """
        folder = Folder()
        target = folder / "thermodynamics" if out is None else Path(out)
        given = flags(temperatures=temperatures, free_energy_at=free_energy_at)
        told = command("thermodynamics", self.folder, "--json", *given, "--output", target, progress=False)
        made: dict[str, Any] = json.loads(told)
        return made

    def rates(
        self, from_: Sequence[str | int], to: Sequence[str | int], temperature: float | Sequence[float], *,
        friction: float | None = None, pathways: int = 5, out: StrPath | None = None,
    ) -> dict[str, Any]:
        """Rates and fastest pathways between two sets of minima (numbers, or names such as ``"m3"``), as
        ``landscape rates --json``. ``temperature``: in units of the energy."""
        folder = Folder()
        target = folder / "rates" if out is None else Path(out)
        named = [[name if isinstance(name, str) else f"m{name}" for name in names] for names in (from_, to)]
        degrees = [temperature] if isinstance(temperature, (int, float)) else list(temperature)
        told = command(
            "rates", self.folder, "--json",
            *flags(from_=named[0], to=named[1], temperature=degrees, friction=friction, pathways=pathways),
            "--output", target, progress=False,
        )
        made: dict[str, Any] = json.loads(told)
        return made

    def write_pathsample(self, out: StrPath) -> Path:
        """Writes ``min.data``, ``ts.data`` and, of searched surfaces, ``points.min`` and ``points.ts`` into the folder ``out``
        (PATHSAMPLE of D. J. Wales; coordinates as 64-bit numbers)."""
        target = Path(out)
        target.mkdir(parents=True, exist_ok=True)
        for name in ("min.data", "ts.data", "points.min", "points.ts"):
            if (self.folder / name).is_file():
                shutil.copyfile(self.folder / name, target / name)
        return target

    def save(self, out: StrPath) -> Landscape:
        """Copies the folder to ``out``, which must not exist, and returns the landscape there."""
        shutil.copytree(self.folder, out)
        return Landscape(out)

    def __repr__(self) -> str:
        counts = self.manifest["counts"]
        return f"Landscape of {counts['minima']} minima in {counts['groups']} groups ({self.folder})"


def _folder(landscape: Landscape | StrPath) -> Path:
    return landscape.folder if isinstance(landscape, Landscape) else existing(landscape)


def load(folder: StrPath) -> Landscape:
    """The landscape in ``folder``. Its tables are checked against their checksums."""
    return Landscape(folder)


def build(
    grasps: Grasps,
    out: StrPath | None = None,
    *,
    neighbours: int | None = None,
    temperature: float | None = None,
    pull: float | None = None,
    diagram: bool = False,
    paths: str = "string",
    sequential: bool = False,
    group_barrier: float | None = None,
    only_stable: bool = False,
    first: int | None = None,
    seed: int = 0,
    onto: Landscape | StrPath | None = None,
    report: bool = False,
    progress: bool | None = None,
) -> Landscape:
    """The landscape between grasps of one hand on one object: the same bytes as ``landscape build``.

    Parameters
    ----------
    grasps
        The grasps. A landscape needs two at least.
    out
        The folder to write. An interrupted call with the same ``out`` goes on where it stopped. By default a temporary folder,
        which vanishes with the landscape (:meth:`Landscape.save` keeps it).
    neighbours, temperature, pull, diagram, paths, sequential, group_barrier, only_stable, first
        As the flags of ``landscape build``.
    seed
        Seed of all random draws. The result depends on nothing else.
    onto
        A finished landscape to which the grasps are added, with its settings; only what is new is done.
    report
        Whether to write ``report.html`` into the folder.
    progress
        Whether to show a progress bar; by default if standard error is a terminal.

    Raises
    ------
    InputError
        If an argument is wrong, or all grasps lie in one minimum.
    KeyboardInterrupt
        On Ctrl-C, within a second. Finished work is kept in ``out``.
    """
    if len(grasps.populations) > 1:
        raise InputError("the grasps are of several hands, objects or scales: take those of one pair first")
    keeps = None if out is not None else Folder()
    target = Path(out) if keeps is None else keeps / "grasps.landscape"  # type: ignore[arg-type]
    given = flags(
        neighbours=neighbours, temperature=temperature, pull=pull, diagram=diagram,
        paths=None if paths == "string" else paths, sequential=sequential, group_barrier=group_barrier,
        only_stable=only_stable, first=first, seed=seed or None, onto=None if onto is None else _folder(onto),
        no_report=not report,
    )
    command("build", grasps._file(), *given, "--quiet", "--output", target, progress=progress)
    return Landscape(target, _keeps=keeps)


def import_landscape(folder: StrPath, out: StrPath | None = None, *, group_barrier: float | None = None) -> Landscape:
    """A landscape from ``min.data`` and ``ts.data`` of PATHSAMPLE or topsearch in ``folder``."""
    keeps = None if out is not None else Folder()
    target = Path(out) if keeps is None else keeps / "imported.landscape"  # type: ignore[arg-type]
    given = flags(group_barrier=group_barrier, no_report=True)
    command("import", existing(folder), *given, "--quiet", "--output", target, progress=False)
    return Landscape(target, _keeps=keeps)


def diversity(
    *sets: Grasps | Landscape | StrPath, group_barrier: float | None = None, resamplings: int | None = None, seed: int = 0,
    out: StrPath | None = None, progress: bool | None = None,
) -> dict[str, Any]:
    """Which of several sets of grasps is more diverse, as ``landscape diversity --json``: effective numbers of kinds.

    Sets have the names of their files and folders; grasps that are in memory only are called ``set_1.parquet``,
    ``set_2.parquet``, … by their place among the arguments.
    """
    from ._grasps import Grasps

    folder = Folder()
    stem = folder / "diversity" if out is None else Path(out)
    paths = [
        each._file(folder / f"set_{place}.parquet") if isinstance(each, Grasps) else _folder(each)
        for place, each in enumerate(sets, 1)
    ]
    given = flags(group_barrier=group_barrier, resamplings=resamplings, seed=seed or None)
    told = command("diversity", *paths, "--json", *given, "--output", stem, progress=progress)
    made: dict[str, Any] = json.loads(told)
    return made
