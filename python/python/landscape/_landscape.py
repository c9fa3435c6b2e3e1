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
from ._checks import instance, numbers, whole, whole_or_none
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
    """Energy by term, shape (points,) each; empty for an energy without terms, and from a minimum to itself."""

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
    """The disconnectivity graph of a landscape (O. M. Becker and M. Karplus, J. Chem. Phys. 106, 1495 (1997)).

    Nodes 0 to n − 1 are the minima; a merge has a larger number than its branches.
    """

    def __init__(self, native: _native.Folder, folder: Path, keeps: Folder | None) -> None:
        self._native, self._folder, self._keeps = native, folder, keeps

    @cached_property
    def nodes(self) -> Table:
        """``energy`` (of the minimum, or of the pass), ``parent`` (−1 for a root), ``minimum`` (−1 for a merge) and
        ``evidence`` (``saddle``, ``given``, ``path`` or ``chain``)."""
        return Table(self._native.nodes())

    def merge_height(self, a: int, b: int) -> float:
        """The lowest height at which two minima are connected: the energy of the lowest pass found; +inf if they are
        not.

        Parameters
        ----------
        a, b
            Numbers of minima, from 0.

        Raises
        ------
        InputError
            If there is no such minimum.
        """
        height = self._native.minimax(whole("a", a), whole("b", b))
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
    """What differs between two landscapes: what :meth:`Landscape.diff` returns."""

    def __init__(self, told: dict[str, Any]) -> None:
        self.told = told
        """All of it, as ``landscape diff --json`` tells it."""

    @property
    def matches(self) -> Table:
        """Corresponding minima: ``before``, ``after``, their energies and their distance."""
        return _pairs(self.told["matches"])

    @property
    def possible(self) -> Table:
        """Minima without a match beside the one that each may be, as in :attr:`matches`: the nearest of equal energy."""
        return _pairs(self.told["possible"])

    @property
    def only_before(self) -> list[int]:
        """Minima of the first landscape without a match and without a possible one."""
        return list(self.told["only_before"])

    @property
    def only_after(self) -> list[int]:
        """Minima of the second landscape without a match and without a possible one."""
        return list(self.told["only_after"])

    def to_pandas(self) -> Any:
        """The corresponding minima as a ``pandas.DataFrame``."""
        return self.matches.to_pandas()

    def __repr__(self) -> str:
        only = f"{len(self.only_before)} only before, {len(self.only_after)} only after"
        return f"{self.matches.rows} minima in both, {self.possible.rows} pairs may be the same, {only}"


def _pairs(rows: list[dict[str, Any]]) -> Table:
    """Pairs of minima of two landscapes."""
    return Table({
        "before": np.array([row["before"] for row in rows], dtype=np.int64),
        "after": np.array([row["after"] for row in rows], dtype=np.int64),
        "energy_before": np.array([row["energies"][0] for row in rows], dtype=np.float64),
        "energy_after": np.array([row["energies"][1] for row in rows], dtype=np.float64),
        "distance": np.array([row["distance"] for row in rows], dtype=np.float64),
    })


class Landscape:
    """A landscape folder of ``landscape build``, ``surface`` or ``import``, or of :func:`build`, :func:`explore`, :func:`map`.

    Minima are numbered from 0 by energy. Tables are copies of what is in the folder, made at the first use.

    Parameters
    ----------
    folder
        The folder.

    Raises
    ------
    InputError
        If the folder holds no landscape, or a table differs from its checksum.
    FileNotFoundError
        If there is no such folder.
    """

    def __init__(self, folder: StrPath, *, _keeps: Folder | None = None) -> None:
        self.folder: Path = existing(folder)
        """The folder. A temporary one vanishes with the landscape and its tree; :meth:`save` keeps a copy."""
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
        """``energy``, ``coordinates`` (n, d), ``family``, ``members`` (ids of the inputs that descend to it) and ``label`` of
        each minimum, lowest first. Coordinates of grasps are poses as in :attr:`Grasps.poses`."""
        return Table(self._native.minima())

    @cached_property
    def edges(self) -> Table:
        """The pairs that were tried: ``a``, ``b``, ``height`` (NaN: no path), ``relative_barrier``, ``length`` (of the path,
        metres for grasps), ``evidence``, ``term`` (that rises most), ``way`` (sliding, rolling, regrasping, letting go),
        ``chain_runs`` (of sequential ADELM), ``evaluations``."""
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
        return Tree(self._native, self.folder, self._keeps)

    @property
    def grasps(self) -> Grasps | None:
        """The grasps that were mapped, whose ids are the ``members`` of minima; ``None`` for a landscape of a surface."""
        from ._grasps import Grasps

        file = self.folder / "grasps.parquet"
        return Grasps.read(file) if file.is_file() else None

    @property
    def families(self) -> NDArray[np.int64]:
        """The family of each minimum, shape (n,): minima that are joined below the family barrier."""
        families: NDArray[np.int64] = self.minima["family"]
        return families

    @property
    def family_barrier(self) -> float | None:
        """Greatest relative barrier within a family, in units of the energy."""
        barrier: float | None = self.manifest["family_barrier"]
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
    def unseen_families(self) -> dict[str, Any] | None:
        """Estimate of families that the inputs did not show, as in ``landscape.json``: rarefaction and Chao1 (A. Chao, Scand. J.
        Stat. 11, 265 (1984))."""
        told = self.manifest["findings"].get("rarefaction") or {}
        found: dict[str, Any] | None = told.get("families")
        return found

    def path(self, a: int, b: int, *, terms: bool = True) -> MinimaxPath | None:
        """The minimax path between two minima; ``None`` if none joins them. From a minimum to itself it is one point.

        Parameters
        ----------
        a, b
            Numbers of minima, from 0.
        terms
            Whether to compute the energy by term along the path of grasps.

        Raises
        ------
        InputError
            If there is no such minimum, or the landscape does not record its space.
        """
        found = self._native.path(whole("a", a), whole("b", b), terms)
        if found is None:
            return None
        if a == b:
            here = {name: self.minima[name][a : a + 1] for name in ("coordinates", "energy")}
            found.update(here, length=np.zeros(1), terms={})
        return MinimaxPath(**found)

    def draw_path(
        self, a: int, b: int, out: StrPath, *, pictures: int | None = None, force: bool = False
    ) -> list[Path]:
        """Draws the minimax path between two minima of grasps, and returns the paths of three files: ``.png`` and ``.svg``
        (pictures of the hand over the energy by term) and ``.glb`` (an animation).

        Parameters
        ----------
        a, b
            Numbers of two minima, from 0.
        out
            The files to write, without their endings.
        pictures
            Number of pictures along the path; 8 by default.
        force
            Whether to replace files that landscape did not write.

        Raises
        ------
        InputError
            If the landscape is not one of grasps, no path joins the minima, or landscape did not write a file.
        """
        ends = [f"m{whole(name, end)}" for name, end in (("a", a), ("b", b))]
        given = flags(pictures=pictures, force=force)
        command("inspect", self.folder, "--path", *ends, *given, "--quiet", "--output", out, progress=False)
        stem = Path(out)
        return [stem.with_name(stem.name + ending) for ending in (".png", ".svg", ".glb")]

    def newick(self) -> str:
        """The tree in Newick format."""
        return self.tree.newick()

    def diff(self, other: Landscape | StrPath, *, within: float | None = None) -> Difference:
        """What differs in another landscape.

        Parameters
        ----------
        other
            A landscape of the same hand, or of the same space.
        within
            Greatest distance of corresponding minima (metres for grasps); by default the tolerance with which the landscapes
            were made.

        Raises
        ------
        InputError
            If the landscapes cannot be compared.
        """
        told = command("diff", self.folder, _folder(other), "--json", *flags(within=within), progress=False)
        return Difference(json.loads(told))

    def compare(
        self, other: Landscape | StrPath | None = None, *, out: StrPath | None = None, family_barrier: float | None = None,
        seed: int = 0, force: bool = False, progress: bool | None = None,
    ) -> str:
        """Tests how the landscape agrees with the GRASP taxonomy (T. Feix et al., IEEE Trans. Hum.-Mach. Syst. 46, 66 (2016)),
        or which of its types two landscapes hold. Returns the text.

        Tests are by permutation: Mantel (N. Mantel, Cancer Res. 27, 209 (1967)), PERMANOVA (M. J. Anderson, Austral Ecol. 26,
        32 (2001)) and others, which the text names.

        Parameters
        ----------
        other
            Another landscape, of any hand and object.
        out
            The files to write, without their endings ``.md``, ``.json``, ``.svg`` and ``.png``; by default none are kept.
        family_barrier
            As in :func:`build`, in units of the energy; by default that of the landscape.
        seed
            Seed of permutations and resamplings.
        force
            Whether to replace files that landscape did not write.
        progress
            Whether to show progress bars; by default if standard error is a terminal.

        Raises
        ------
        InputError
            If a landscape is not one of grasps, or landscape did not write a file.
        """
        folder = Folder()
        stem = folder / "comparison" if out is None else Path(out)
        words = [] if other is None else [_folder(other)]
        given = flags(family_barrier=family_barrier, seed=whole("seed", seed) or None, force=force)
        command("compare", self.folder, *words, *given, "--quiet", "--output", stem, progress=progress)
        written = stem.with_name(stem.name + ".md").read_text(encoding="utf-8")
        # The last line of the file is a comment that tells its maker.
        return written.rsplit("\n<!-- ", 1)[0]

    def draw(
        self, out: StrPath, *, lowest: int | None = None, deepest: int | None = None,
        min_members: int | None = None, monotonic: bool = False,
        pick: Sequence[str] | None = None, levels: int | None = None, place_by: str | None = None,
        colour_by: str | None = None, values: StrPath | None = None, examples: int | None = None,
        colour: Literal["category", "type", "power", "spheres"] | None = None, stability: StrPath | None = None,
        family_barrier: float | None = None, seed: int | None = None, force: bool = False,
    ) -> Path:
        """Draws the landscape and returns the path.

        Parameters
        ----------
        out
            A folder for all pictures and texts (a name without an ending, or with ``.view``), or a file ending in ``.svg`` or
            ``.png`` for the disconnectivity graph alone.
        lowest, deepest, min_members, pick, monotonic
            Which minima are drawn: the lowest ones, those of the deepest branches, those with as many members, those named
            (such as ``"m3"``), and those that no lower neighbour drains (monotonic sequences: R. S. Berry and R.
            Breitengraser-Kunz, Phys. Rev. Lett. 74, 3951 (1995)).
        levels
            Number of levels at which branches join, as in published disconnectivity graphs.
        place_by, colour_by, values
            Quantities that place or colour the minima, and a CSV file with values of yours.
        colour, stability
            Colours of grasps: differences between their types, or a file of :meth:`Grasps.stability` with what held.
        examples
            Number of rendered grasps below the graph.
        family_barrier
            As in :func:`build`, in units of the energy; by default that of the landscape.
        seed
            Seed of the layout; by default that of the landscape.
        force
            Whether to replace a file that landscape did not write, or to write beside the files of others in a folder.

        Raises
        ------
        InputError
            If an argument or the ending of ``out`` is wrong, landscape did not write what is there, or there is no tree to
            draw.
        """
        target = Path(out)
        ending = target.suffix.lower()
        picture = ending if ending in (".svg", ".png") else None
        if picture is None and ending not in ("", ".view") and not target.is_dir():
            raise InputError(f"out {target}: pictures end in .svg or .png, and folders in .view or nothing")
        if picture is not None:
            _native.check_output(target, force)
        keeps = Folder()
        folder = target if picture is None else keeps / "view"
        given = flags(
            lowest=lowest, deepest=deepest, min_members=min_members, monotonic=monotonic,
            pick=None if pick is None else list(pick), levels=levels, place_by=place_by, colour_by=colour_by, values=values,
            examples=examples, colour=colour, stability=stability, family_barrier=family_barrier,
            seed=whole_or_none("seed", seed), force=force,
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
        force: bool = False, progress: bool | None = None,
    ) -> Path:
        """Writes the page on which the landscape is explored in a browser, and returns its path.

        Parameters
        ----------
        out
            The file to write (HTML); by default beside the folder, with the ending ``.report.html``. Beside a temporary folder
            it is kept until the interpreter ends.
        other
            Another landscape, which is shown face to face.
        stability
            A file of :meth:`Grasps.stability` with what held.
        force
            Whether to replace a file that landscape did not write.
        progress
            Whether to show progress bars; by default if standard error is a terminal.

        Raises
        ------
        InputError
            If the landscapes cannot be shown together, or landscape did not write the file.
        """
        target = self.folder.with_suffix(".report.html") if out is None else Path(out)
        words = [] if other is None else [_folder(other)]
        given = flags(stability=stability, force=force)
        command("report", self.folder, *words, *given, "--quiet", "--output", target, progress=progress)
        if out is None and self._keeps is not None:
            self._keeps.keep()
        return target

    def show(self, *, height_px: int = 720) -> Page:
        """The page of :meth:`report` as a widget of a notebook; needs ``anywidget``. What is chosen on it is ``selected``.

        Parameters
        ----------
        height_px
            Height on the screen, pixels.
        """
        from .widget import Page

        return Page.of(self.report, height_px)

    def thermodynamics(
        self, out: StrPath | None = None, *, temperatures: str | None = None, free_energy_at: float | None = None,
        without_faces: bool = False, force: bool = False,
    ) -> dict[str, Any]:
        """Heat capacity, occupation of minima and free energies against temperature, as ``landscape thermodynamics --json``.

        Minima are harmonic wells (F. H. Stillinger and T. A. Weber, Phys. Rev. A 25, 978 (1982); D. J. Wales, *Energy
        Landscapes* (2003)). Temperatures are kT, in units of the energy; all atoms have mass 1.

        Parameters
        ----------
        out
            The folder to write; by default none is kept.
        temperatures
            ``"LOW:HIGHxN"``: N temperatures from LOW to HIGH; by default where the occupation of the minima changes.
        free_energy_at
            Temperature of the free energies in the disconnectivity graph; by default that of the highest peak of the heat
            capacity.
        without_faces
            Whether to leave out minima without curvatures, such as those on a face of a box, and the saddles that lead to them;
            ``notes`` then tells how many there are, and their energies.
        force
            Whether to write beside the files of others in the folder.

        Raises
        ------
        InputError
            If a temperature is wrong, or curvatures of minima are not known.
        """
        folder = Folder()
        target = folder / "thermodynamics" if out is None else Path(out)
        given = flags(temperatures=temperatures, free_energy_at=free_energy_at, without_faces=without_faces, force=force)
        told = command("thermodynamics", self.folder, "--json", *given, "--quiet", "--output", target, progress=False)
        made: dict[str, Any] = json.loads(told)
        return made

    def rates(
        self, from_: str | int | Sequence[str | int], to: str | int | Sequence[str | int], temperature: float | Sequence[float],
        *, friction: float | None = None, pathways: int = 5, without_faces: bool = False, out: StrPath | None = None,
        force: bool = False,
    ) -> dict[str, Any]:
        """Rates and fastest pathways between two sets of minima, as ``landscape rates --json``: harmonic transition-state
        theory, and graph transformation (S. A. Trygubenko and D. J. Wales, J. Chem. Phys. 124, 234110 (2006)).

        Times are in units of √(mass · length² / energy), with mass 1 everywhere; rates are told as natural logarithms.

        Parameters
        ----------
        from_, to
            Minima where ways start and where they arrive: numbers, names of minima and families such as ``"m3"`` and
            ``"g1"``, or the path of a file such as ``min.A`` of PATHSAMPLE.
        temperature
            One or several temperatures kT, in units of the energy.
        friction
            Friction γ in units of 1/time, for the rates of H. A. Kramers, Physica 7, 284 (1940); without it, those of
            transition-state theory.
        pathways
            Number of pathways to tell, fastest first.
        without_faces
            As in :meth:`thermodynamics`.
        out
            The files to write, without their endings ``.md``, ``.json``, ``.svg`` and ``.png``; by default none are kept.
        force
            Whether to replace files that landscape did not write.

        Raises
        ------
        InputError
            If there is no such minimum, a number is wrong, or the landscape has no curvatures.
        """
        folder = Folder()
        target = folder / "rates" if out is None else Path(out)
        given = flags(
            from_=_names("from_", from_), to=_names("to", to), temperature=numbers("temperature", temperature).ravel().tolist(),
            friction=friction, pathways=whole("pathways", pathways), without_faces=without_faces,
            force=force,
        )
        told = command("rates", self.folder, "--json", *given, "--quiet", "--output", target, progress=False)
        made: dict[str, Any] = json.loads(told)
        return made

    def write_pathsample(self, out: StrPath) -> Path:
        """Writes the files of PATHSAMPLE (D. J. Wales), and returns the folder: ``min.data``, ``ts.data`` and, of searched
        surfaces, ``points.min`` and ``points.ts`` (coordinates as 64-bit numbers).

        Parameters
        ----------
        out
            The folder, which is made if there is none. Files with these names are replaced.

        Raises
        ------
        OSError
            If a file cannot be written.
        """
        target = Path(out)
        target.mkdir(parents=True, exist_ok=True)
        for name in ("min.data", "ts.data", "points.min", "points.ts"):
            if (self.folder / name).is_file():
                shutil.copyfile(self.folder / name, target / name)
        return target

    def save(self, out: StrPath) -> Landscape:
        """Copies the folder, and returns the landscape there.

        Parameters
        ----------
        out
            The new folder, which must not exist.

        Raises
        ------
        FileExistsError
            If it exists.
        """
        shutil.copytree(self.folder, out)
        return Landscape(out)

    def __repr__(self) -> str:
        counts = self.manifest["counts"]
        return f"Landscape of {counts['minima']} minima in {counts['families']} families ({self.folder})"


def _folder(landscape: Landscape | StrPath) -> Path:
    return landscape.folder if isinstance(landscape, Landscape) else existing(landscape)


def _names(name: str, given: str | int | Sequence[str | int]) -> list[str]:
    """Minima as the tree names them."""
    several = [given] if isinstance(given, (str, int, np.integer)) else list(given)
    return [each if isinstance(each, str) else f"m{whole(name, each)}" for each in several]


def load(folder: StrPath) -> Landscape:
    """The landscape in a folder. Its tables are checked against their checksums.

    Parameters
    ----------
    folder
        A folder of ``landscape build``, ``surface`` or ``import``, or of :func:`build`, :func:`explore` or :func:`map`.

    Raises
    ------
    InputError
        If the folder holds no landscape, or a table differs from its checksum.
    FileNotFoundError
        If there is no such folder.
    """
    return Landscape(folder)


def build(
    grasps: Grasps,
    out: StrPath | None = None,
    *,
    neighbours: int | None = None,
    temperature: float | None = None,
    pull: float | None = None,
    search: str = "passes",
    family_barrier: float | None = None,
    only_stable: bool = False,
    first: int | None = None,
    seed: int = 0,
    onto: Landscape | StrPath | None = None,
    connect: tuple[str | int, str | int] | None = None,
    report: bool = False,
    progress: bool | None = None,
) -> Landscape:
    """The landscape between grasps of one hand on one object: the same bytes as ``landscape build``.

    Minima are joined by attraction–diffusion (M. Hill, E. Nijkamp and S.-C. Zhu, Quarterly of Applied Mathematics 77, 269
    (2019), arXiv:1803.01043), and paths relax as strings (W. E, W. Ren and E. Vanden-Eijnden, J. Chem. Phys. 126, 164103
    (2007)). If all grasps lie in one minimum, it is a landscape of one minimum.

    Parameters
    ----------
    grasps
        The grasps. A landscape needs two at least.
    out
        The folder to write. An interrupted call with the same ``out`` goes on where it stopped. By default a temporary folder,
        which vanishes with the landscape (:meth:`Landscape.save` keeps it).
    neighbours
        Number of nearest minima to which each minimum is connected.
    temperature, pull
        Temperature and force of attraction–diffusion: units of the energy, and energy per metre. By default they are chosen.
    search
        How the minima are joined: ``"passes"`` by relaxed paths and attraction–diffusion searches across every merge,
        ``"adelm"`` by attraction–diffusion alone as published, one minimum after the other; every barrier is then an upper
        bound.
    family_barrier
        Greatest relative barrier within a family, in units of the energy; by default it is chosen.
    only_stable
        Whether to map only the grasps that held in simulation.
    first
        Number of grasps to map, from the first; by default all.
    seed
        Seed of all random draws. The result depends on nothing else.
    onto
        A finished landscape to which the grasps are added, with its settings; only what is new is done.
    connect
        Two minima of ``onto`` between which 40 further searches look for a lower way. There need be no new grasp.
    report
        Whether to write ``report.html`` into the folder.
    progress
        Whether to show a progress bar; by default if standard error is a terminal.

    Raises
    ------
    InputError
        If an argument is wrong, there are fewer than two grasps, or they are not of one hand on one object at one scale.
    KeyboardInterrupt
        On Ctrl-C, within a second. Finished work is kept in ``out``.
    """
    from ._grasps import Grasps

    instance("grasps", grasps, Grasps)
    if len(grasps.populations) > 1:
        raise InputError("the grasps are of several hands, objects or scales: take those of one pair first")
    keeps = None if out is not None else Folder()
    target = Path(out) if keeps is None else keeps / "grasps.landscape"  # type: ignore[arg-type]
    given = flags(
        neighbours=neighbours, temperature=temperature, pull=pull,
        search=None if search == "passes" else search, family_barrier=family_barrier,
        only_stable=only_stable, first=first, seed=whole("seed", seed) or None, onto=None if onto is None else _folder(onto),
        no_report=not report,
    )
    pair = [] if connect is None else ["--connect", *_names("connect", connect)]
    command("build", grasps._file(), *given, *pair, "--quiet", "--output", target, progress=progress)
    return Landscape(target, _keeps=keeps)


def import_landscape(folder: StrPath, out: StrPath | None = None, *, family_barrier: float | None = None) -> Landscape:
    """A landscape from ``min.data`` and ``ts.data`` of PATHSAMPLE (D. J. Wales) or topsearch.

    Parameters
    ----------
    folder
        The folder with these files, and with ``points.min`` and ``points.ts`` if there are any.
    out
        The folder to write; by default a temporary one, which vanishes with the landscape.
    family_barrier
        As in :func:`build`, in units of the energy.

    Raises
    ------
    InputError
        If the folder has no such files, or a line of them is wrong.
    FileNotFoundError
        If there is no such folder.
    """
    source = existing(folder)
    if not (source / "min.data").is_file():
        raise InputError(f"{source}: a folder with min.data and ts.data is needed")
    keeps = None if out is not None else Folder()
    target = Path(out) if keeps is None else keeps / "imported.landscape"  # type: ignore[arg-type]
    given = flags(family_barrier=family_barrier, no_report=True)
    command("import", source, *given, "--quiet", "--output", target, progress=False)
    return Landscape(target, _keeps=keeps)


def judge(
    *sets: Grasps | StrPath, tests: Sequence[str] | None = None, measures: Sequence[str] | None = None, at: int | None = None,
    seed: int = 0, out: StrPath | None = None, force: bool = False, progress: bool | None = None,
) -> dict[str, Any]:
    """Sets of grasps under published tests and measures, as ``landscape judge --json``.

    Parameters
    ----------
    sets
        Grasps and files of grasps, whose names they have in the result. Grasps that are in memory only are called
        ``set_1.parquet``, ``set_2.parquet``, … by their place among the arguments.
    tests, measures
        Names of tests and measures; by default all. Empty for none.
    at
        Number of grasps of each object that measures see, so that sets of different size are comparable; by default all.
    seed
        Seed of the resamplings.
    out
        The files to write, without their endings ``.md``, ``.json``, ``.csv``, ``.grasps.csv``, ``.svg`` and ``.png``; by
        default none are kept.
    force
        Whether to replace files that landscape did not write.
    progress
        Whether to show progress bars; by default if standard error is a terminal.

    Raises
    ------
    InputError
        If a name is unknown, or a set has no grasps.
    """
    from ._grasps import Grasps

    folder = Folder()
    stem = folder / "judge" if out is None else Path(out)
    paths = [
        each._file(folder / f"set_{place}.parquet") if isinstance(each, Grasps) else Path(each)
        for place, each in enumerate(sets, 1)
    ]
    chosen = {name: None if names is None else ",".join(names) or "none" for name, names in [("tests", tests), ("measures", measures)]}
    given = flags(**chosen, at=at, seed=whole("seed", seed) or None, force=force)
    told = command("judge", *paths, "--json", *given, "--quiet", "--output", stem, progress=progress)
    made: dict[str, Any] = json.loads(told)
    return made


def diversity(
    *sets: Grasps | Landscape | StrPath, family_barrier: float | None = None, resamplings: int | None = None, seed: int = 0,
    out: StrPath | None = None, force: bool = False, progress: bool | None = None,
) -> dict[str, Any]:
    """Which of several sets of grasps is more diverse and by how much, as ``landscape diversity --json``: effective numbers of
    kinds and their ratios (M. O. Hill, Ecology 54, 427 (1973)), rarefied to equal numbers of grasps (A. Chao and L. Jost, Ecology 93, 2533 (2012)).

    Parameters
    ----------
    sets
        Grasps, landscapes, and their files and folders, whose names they have in the result. Grasps that are in memory only
        are called ``set_1.parquet``, ``set_2.parquet``, … by their place among the arguments. Each needs 30 grasps.
    family_barrier
        As in :func:`build`, in units of the energy: the level at which families of landscapes are compared.
    resamplings
        Number of resamplings for each interval.
    seed
        Seed of the resamplings.
    out
        The files to write, without their endings ``.md``, ``.json``, ``.svg`` and ``.png``; by default none are kept.
    force
        Whether to replace files that landscape did not write.
    progress
        Whether to show progress bars; by default if standard error is a terminal.

    Raises
    ------
    InputError
        If a set has fewer than 30 grasps, or a number is wrong.
    """
    from ._grasps import Grasps

    folder = Folder()
    stem = folder / "diversity" if out is None else Path(out)
    paths = [
        each._file(folder / f"set_{place}.parquet") if isinstance(each, Grasps) else _folder(each)
        for place, each in enumerate(sets, 1)
    ]
    given = flags(family_barrier=family_barrier, resamplings=resamplings, seed=whole("seed", seed) or None, force=force)
    told = command("diversity", *paths, "--json", *given, "--quiet", "--output", stem, progress=progress)
    made: dict[str, Any] = json.loads(told)
    return made
