"""Grasps as columns, their synthesis, judgement, labels and simulation."""

from __future__ import annotations

import io
import json
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._acronym import ENDINGS, as_table
from ._call import Folder, StrPath, command, existing, flags
from ._checks import instance, numbers, whole, whole_or_none
from ._errors import InputError
from ._hands import Hand, Object, synthesized
from ._table import Table

if TYPE_CHECKING:
    from ._landscape import Landscape
    from .widget import Page

Floats = NDArray[np.float64]
RotationForm = Literal["wxyz", "xyzw", "matrix"]
Keep = Literal["strict", "published", "all"]
Protocol = Literal[
    "drop", "dexgraspbench", "dexgraspbench-hard", "dexgraspnet", "graspqp", "graspqp-all", "gendexgrasp", "graspdatagen",
]
Rows = Union[int, slice, NDArray[Any], Sequence[int], Sequence[bool]]

#: Columns of numbers and texts that :meth:`Grasps.column` knows.
COLUMNS = (
    "id", "hand", "object", "scale", "energy", "net_wrench", "distance_squared", "penetration", "friction", "epsilon",
    "stable", "stable_reason", "stable_displacement_m", "stable_turn_rad", "label", "label_auto", "label_score",
    "label_best", "label_category", "label_source", "source", "chain_seed", "chain_step",
)


class Evaluation(NamedTuple):
    """Energies of many poses: what :class:`Energy` returns for grasps."""

    energy: Floats
    """Shape (n,)."""
    gradient: Floats
    """Derivatives along the tangents of each pose, shape (n, tangents): three of translation and three of rotation, scaled so
    that a tangent of length 1 moves the surface of the hand by 1 m in the root mean square, then one for each joint."""
    terms: dict[str, Floats]
    """Weighted terms by name, shape (n,) each. They add up to ``energy``."""


def _quaternions(rotation: ArrayLike, form: str) -> Floats:
    """Unit quaternions w, x, y, z, shape (n, 4)."""
    given = numbers("rotation", rotation)
    if form == "wxyz" or form == "xyzw":
        if given.ndim != 2 or given.shape[1] != 4:
            raise InputError(f"rotation has the shape {given.shape}, but (n, 4) is needed for {form}")
        return given if form == "wxyz" else given[:, [3, 0, 1, 2]]
    if form != "matrix":
        raise InputError(f"rotation_form {form!r}: the forms are 'wxyz', 'xyzw' and 'matrix'")
    if given.ndim != 3 or given.shape[1:] != (3, 3):
        raise InputError(f"rotation has the shape {given.shape}, but (n, 3, 3) is needed for matrices")
    wrong = np.abs(given @ given.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2)) > 1e-3
    wrong |= np.linalg.det(given) < 0 if len(given) else False
    if wrong.any():
        raise InputError(f"rotation: the matrix of row {int(np.flatnonzero(wrong)[0])} is not a rotation")
    # Of four formulas the one with the largest divisor (S. W. Shepperd, J. Guid. Control 1, 223 (1978)).
    m = given
    trace = np.einsum("nii->n", m)
    squares = np.stack([trace, m[:, 0, 0], m[:, 1, 1], m[:, 2, 2]], axis=1)
    best = squares.argmax(axis=1)
    result = np.empty((len(m), 4))
    for row, place in enumerate(best):
        r = m[row]
        if place == 0:
            q = [1 + trace[row], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]
        else:
            i = place - 1
            j, k = (i + 1) % 3, (i + 2) % 3
            q = [0.0] * 4
            q[0] = r[k, j] - r[j, k]
            q[1 + i] = 1 + r[i, i] - r[j, j] - r[k, k]
            q[1 + j] = r[j, i] + r[i, j]
            q[1 + k] = r[k, i] + r[i, k]
        result[row] = np.asarray(q) / np.linalg.norm(q)
    return result


def _contact_sets(contacts: Sequence[Sequence[int]]) -> list[list[int]]:
    """Contact sets as lists of whole numbers."""
    try:
        rows = [list(row) for row in contacts]
    except TypeError:
        raise InputError("contacts: a list of whole numbers for each grasp is needed") from None
    return [[whole(f"contacts: row {place} has", point, most=2**32 - 1) for point in row] for place, row in enumerate(rows)]


class Grasps:
    """Grasps of a hand on an object (or of several) as columns. Grasps are never changed: methods return new ones.

    ``grasps[mask]``, ``grasps[3:9]``, ``grasps[[1, 5]]`` and ``grasps[0]`` are grasps again. Arrays are read only: the
    columns ``translation_m``, ``rotation_wxyz`` and ``joints`` are views of ``poses``, which is copied once. Take a copy
    to write into one. Make grasps with :func:`synthesize`, :meth:`read`, :meth:`from_arrays` or :meth:`from_table`.
    """

    def __init__(self, native: _native.Grasps, file: Path | None = None, keeps: object = None) -> None:
        self._native = native
        self._keeps = keeps
        self._path = file
        self._written = _state(file)

    # Making and writing

    @classmethod
    def read(cls, file: StrPath, *, hand: Hand | None = None, object: Object | None = None) -> Grasps:
        """Reads ``grasps.parquet``, or a table with the same columns.

        Parameters
        ----------
        file
            The file.
        hand, object
            For a file that does not describe them. If it does and they differ, all measures are computed again.

        Raises
        ------
        InputError
            If the file is wrong; the sentence names row and column.
        FileNotFoundError
            If there is no such file.
        """
        path = existing(file)
        if hand is not None:
            instance("hand", hand, Hand)
        if object is not None:
            instance("object", object, Object)
        native = _native.Grasps.read(
            path, None if hand is None else hand._native, None if object is None else object._native
        )
        return cls(native, path if hand is None and object is None else None)

    @classmethod
    def from_arrays(
        cls,
        hand: Hand,
        object: Object,
        *,
        translation_m: ArrayLike,
        rotation: ArrayLike,
        rotation_form: RotationForm,
        joints: ArrayLike,
        contacts: Sequence[Sequence[int]] | None = None,
        source: str = "",
    ) -> Grasps:
        """Grasps of your own, measured.

        Parameters
        ----------
        hand, object
            The hand and the object of all rows.
        translation_m
            Positions of the hand's root in the frame of the object, shape (n, 3), metres.
        rotation
            Rotations from the hand's root to the object: unit quaternions of shape (n, 4) or matrices of shape (n, 3, 3).
        rotation_form
            ``"wxyz"`` (scalar first: MuJoCo, Isaac, transforms3d), ``"xyzw"`` (scalar last: SciPy, ROS, PyBullet) or
            ``"matrix"``. There is no default, because a wrong order is not noticed.
        joints
            Joint angles in the order of ``hand.joint_names``, shape (n, joints), radians; metres for sliding joints.
        contacts
            Indices of surface points of the hand, a list for each grasp; by default the best ones are chosen.
        source
            A note on the origin of the grasps.

        Raises
        ------
        InputError
            If a shape or a number is wrong; the sentence names argument and row.
        """
        instance("hand", hand, Hand)
        instance("object", object, Object)
        chosen = None if contacts is None else _contact_sets(contacts)
        native = _native.Grasps.from_arrays(
            hand._native, object._native, translation_m, _quaternions(rotation, rotation_form), joints, chosen, source,
        )
        return cls(native)

    @classmethod
    def from_table(cls, table: Any, *, hand: Hand | None = None, object: Object | None = None) -> Grasps:
        """Grasps from a table of pyarrow, pandas or polars with the columns of :meth:`to_arrow`.

        Parameters
        ----------
        table
            A ``pyarrow.Table``, a ``pandas.DataFrame`` or a ``polars.DataFrame``.
        hand, object
            As in :meth:`read`. pandas and polars drop their description, so that these must be given.

        Raises
        ------
        InputError
            If the table is wrong; the sentence names row and column.
        """
        import pyarrow
        import pyarrow.parquet

        if hasattr(table, "to_arrow") and not isinstance(table, pyarrow.Table):
            table = table.to_arrow()
        elif not isinstance(table, pyarrow.Table):
            table = pyarrow.Table.from_pandas(table, preserve_index=False)
        folder = Folder()
        file = folder / "grasps.parquet"
        pyarrow.parquet.write_table(table, file, compression="snappy")
        return cls(cls.read(file, hand=hand, object=object)._native)

    def write(self, file: StrPath, *, force: bool = False) -> Path:
        """Writes ``grasps.parquet`` and returns its path. Equal grasps give equal bytes.

        Parameters
        ----------
        file
            The file to write. One of landscape is replaced.
        force
            Whether to replace a file that landscape did not write, too.

        Raises
        ------
        InputError
            If the file exists and landscape did not write it, or there are no grasps.
        OSError
            If the file cannot be written.
        """
        path = Path(file)
        _native.check_output(path, force)
        self._native.write(path)
        self._path, self._written, self._keeps = path, _state(path), None
        return path

    def _file(self, named: Path | None = None) -> Path:
        """A file that holds just these grasps: the one that has them, or else ``named``, which the caller keeps."""
        saved = self._path is not None and self._keeps is None and _state(self._path) == self._written
        if named is not None and not saved:
            self._native.write(named)
            return named
        if self._path is None or _state(self._path) != self._written:
            folder = Folder()
            path = folder / "grasps.parquet"
            self.write(path)
            self._keeps = folder
        assert self._path is not None
        return self._path

    # Columns

    def __len__(self) -> int:
        return len(self._native)

    def __getitem__(self, rows: Rows) -> Grasps:
        """Grasps of some rows; a copy.

        Parameters
        ----------
        rows
            A number, a slice, a list or an array of numbers (negative ones count from the end), or a mask of shape (n,). A
            mask may choose none.

        Raises
        ------
        IndexError
            If there is no such row, or a mask has another length.
        InputError
            If a row is chosen twice, because ids are unique.
        """
        count = len(self)
        if isinstance(rows, (int, np.integer)):
            if not -count <= rows < count:
                raise IndexError(f"row {rows} of {count} grasps")
            chosen = [int(rows) % count]
        elif isinstance(rows, slice):
            chosen = list(range(*rows.indices(count)))
        else:
            try:
                given = np.asarray(rows)
            except ValueError:
                raise IndexError("rows are chosen by a list of numbers, not by lists of several lengths") from None
            if given.dtype == np.bool_:
                if given.shape != (count,):
                    raise IndexError(f"a mask of the shape {given.shape} for {count} grasps")
                chosen = np.flatnonzero(given).tolist()
            elif given.ndim == 1 and (np.issubdtype(given.dtype, np.integer) or given.size == 0):
                chosen = [row + count if row < 0 else row for row in given.astype(int).tolist()]
                if any(not 0 <= row < count for row in chosen):
                    raise IndexError(f"rows {given.tolist()} of {count} grasps")
            else:
                raise IndexError("rows are chosen by a number, a slice, a list of numbers or a mask")
        return Grasps(self._native.take(chosen))

    @cached_property
    def poses(self) -> Floats:
        """Poses, shape (n, 7 + joints): position (m), quaternion w, x, y, z, joints (rad); copied at the first use."""
        return _frozen(self._native.poses)

    @property
    def translation_m(self) -> Floats:
        """Positions of the hand's root in the frame of the object, shape (n, 3), metres; a view."""
        return self.poses[:, :3]

    @property
    def rotation_wxyz(self) -> Floats:
        """Unit quaternions from the hand's root to the object, scalar first, w ≥ 0, shape (n, 4); a view."""
        return self.poses[:, 3:7]

    @property
    def joints(self) -> Floats:
        """Joint angles, shape (n, joints), radians; metres for sliding joints; a view."""
        return self.poses[:, 7:]

    @cached_property
    def contacts(self) -> list[NDArray[np.uint32]]:
        """Contact sets: indices of the hand's surface points."""
        return self._native.contacts()

    @cached_property
    def terms(self) -> dict[str, Floats]:
        """Weighted terms of the energy by name, shape (n,) each."""
        values = self._native.terms()
        return {name: _frozen(values[:, place]) for place, name in enumerate(self._native.term_names)}

    def column(self, name: str) -> NDArray[Any]:
        """A column of ``grasps.parquet``, shape (n,); a copy. Missing numbers are NaN, missing texts ``None``.

        Parameters
        ----------
        name
            ``"id"``, ``"energy"``, ``"label_auto"`` and so on: one of ``COLUMNS``.

        Raises
        ------
        InputError
            If there is no such column.
        """
        return self._native.column(name)

    @cached_property
    def id(self) -> NDArray[np.uint64]:
        """Unique numbers of the grasps, shape (n,)."""
        return _frozen(self.column("id"))

    @cached_property
    def energy(self) -> Floats:
        """Total energies, shape (n,)."""
        return _frozen(self.column("energy"))

    @cached_property
    def epsilon(self) -> Floats:
        """Ferrari–Canny ε at friction 0.5, shape (n,): the least wrench that breaks the grasp, of those that contacts of total
        force 1 resist (C. Ferrari and J. Canny, ICRA 1992). Zero or negative: some wrench is not resisted."""
        return _frozen(self.column("epsilon"))

    @cached_property
    def friction(self) -> Floats:
        """Least friction of exact force closure, shape (n,); NaN if none suffices."""
        return _frozen(self.column("friction"))

    @property
    def stable(self) -> Floats:
        """Whether the grasps held in simulation, shape (n,): 1, 0, or NaN if not simulated."""
        return self.column("stable")

    @property
    def hand(self) -> NDArray[Any]:
        """Names of the hands, shape (n,)."""
        return self.column("hand")

    @property
    def object(self) -> NDArray[Any]:
        """Names of the objects, shape (n,)."""
        return self.column("object")

    @property
    def populations(self) -> list[tuple[str, str, float, int]]:
        """Hand, object, scale and number of the grasps of each pair."""
        return self._native.populations()

    @property
    def metadata(self) -> dict[str, Any]:
        """How the grasps were made, and the description of their hands and objects."""
        made: dict[str, Any] = json.loads(self._native.metadata())
        return made

    @property
    def warnings(self) -> list[str]:
        """What was noted when the file was read, one sentence each."""
        return self._native.warnings

    def rotation(self, form: RotationForm) -> Floats:
        """Rotations from the hand's root to the object.

        Parameters
        ----------
        form
            Quaternions ``"wxyz"`` (a view) or ``"xyzw"``, shape (n, 4), or a ``"matrix"``, shape (n, 3, 3).

        Raises
        ------
        InputError
            If there is no such form.
        """
        q = self.rotation_wxyz
        if form == "wxyz":
            return q
        if form == "xyzw":
            return q[:, [1, 2, 3, 0]]
        if form != "matrix":
            raise InputError(f"form {form!r}: the forms are 'wxyz', 'xyzw' and 'matrix'")
        w, x, y, z = q.T
        rows = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
        return np.moveaxis(np.array(rows), 2, 0)

    # Tables

    def to_arrow(self) -> Any:
        """All columns of ``grasps.parquet`` as a ``pyarrow.Table``, with the description of hand and object."""
        import pyarrow.parquet

        # Without grasps, the file holds one as a pattern.
        return pyarrow.parquet.read_table(io.BytesIO(self._native.encode())).slice(0, len(self))

    def to_pandas(self) -> Any:
        """All columns of ``grasps.parquet`` as a ``pandas.DataFrame``."""
        return self.to_arrow().to_pandas()

    def to_polars(self) -> Any:
        """All columns of ``grasps.parquet`` as a ``polars.DataFrame``."""
        import polars

        return polars.read_parquet(io.BytesIO(self._native.encode())).head(len(self))

    # Judgement

    @cached_property
    def judgement(self) -> Table:
        """Judgements on the exact mesh, a row for each grasp.

        ``strict``, ``published`` (Eq. 11 of Liu et al. 2021 as printed), ``released`` (as in the authors' code): whether the
        grasp passes; ``objection``: the first reason why the strict filter refuses it; ``gap_m``, ``deepest_m``,
        ``self_penetration_m`` (metres), ``joint_excess`` (radians; metres for sliding joints), ``least_friction``,
        ``epsilon``, ``net_wrench``, ``digits``, ``contacts`` (dictionaries with ``point``, the index of the surface point,
        ``link``, its name, and ``distance_m``, the signed distance from the mesh), and more. Friction is exact; ε is that
        of :attr:`epsilon`.
        """
        columns = self._native.judge()
        columns["contacts"] = [
            [{"point": point, "link": link, "distance_m": distance} for point, link, distance in row]
            for row in columns["contacts"]
        ]
        return Table(columns)

    def judge(self) -> Table:
        """The same as :attr:`judgement`."""
        return self.judgement

    def passes(self, filter: Literal["strict", "published", "released"] = "strict") -> NDArray[np.bool_]:
        """Which grasps pass a filter, shape (n,).

        Parameters
        ----------
        filter
            A column of :attr:`judgement`: ``"strict"``, ``"published"`` or ``"released"``.

        Raises
        ------
        InputError
            If there is no such filter.
        """
        if filter not in ("strict", "published", "released"):
            raise InputError(f"filter {filter!r}: the filters are 'strict', 'published' and 'released'")
        passed: NDArray[np.bool_] = self.judgement[filter]
        return passed

    def label(
        self, *, by: StrPath | None = None, rule: StrPath | None = None, labels: StrPath | None = None,
        out: StrPath | None = None, force: bool = False, progress: bool | None = None,
    ) -> Grasps:
        """These grasps with their types in the GRASP taxonomy (T. Feix et al., IEEE Trans. Hum.-Mach. Syst. 46, 66 (2016)):
        the columns ``label_auto``, ``label_score``, ``label_best``, ``label_category``, ``label_source``.

        Parameters
        ----------
        by
            A :class:`Labeller`, or its file, which names the grasps in place of the rule. Grasps unlike all that it has seen
            are named by the rule; ``label_source`` tells which are.
        rule
            A file with another rule than the standard one.
        labels
            A CSV file with your labels (columns ``id`` and ``label``), which override the rule.
        out
            The file to write, the same as that of ``landscape label``; by default none is kept.
        force
            Whether to replace a file that landscape did not write.
        progress
            Whether to show a progress bar; by default if standard error is a terminal.

        Raises
        ------
        InputError
            If a file is wrong, the labeller was taught beside another rule, or there are no grasps.
        """
        given = flags(by=by, rule=rule, from_=labels, force=force)
        return self._remade("label", given, out, "labelled", progress)

    def labels(self, *, progress: bool | None = None) -> Table:
        """Types of the grasps by the standard rule: columns ``id``, ``label_auto``, ``label_score``, ``label_category``.

        Parameters
        ----------
        progress
            As in :meth:`label`.

        Raises
        ------
        InputError
            If there are no grasps.
        """
        labelled = self.label(progress=progress)
        return Table({name: labelled.column(name) for name in ("id", "label_auto", "label_score", "label_category")})

    def stability(
        self, protocol: Protocol = "drop", *, config: StrPath | None = None, out: StrPath | None = None,
        force: bool = False, progress: bool | None = None,
    ) -> Grasps:
        """These grasps with the outcomes of a simulation: the columns ``stable`` (1 or 0), ``stable_reason``,
        ``stable_displacement_m`` (metres) and ``stable_turn_rad`` (radians).

        Parameters
        ----------
        protocol
            ``"drop"`` (T. Liu et al., arXiv:2104.09194), ``"dexgraspbench"`` or another published test:
            ``landscape stability --help`` lists them.
        config
            A TOML file with a protocol of your own.
        out
            The file to write, the same as that of ``landscape stability``; by default none is kept.
        force, progress
            As in :meth:`label`.

        Raises
        ------
        InputError
            If the protocol is wrong, or there are no grasps.
        """
        # The default is not named, as on the command line.
        named = None if protocol == "drop" or config is not None else protocol
        given = flags(protocol=named, config=config, force=force)
        return self._remade("stability", given, out, "stability", progress)

    def stability_in_mujoco(self, protocol: Protocol = "drop") -> Table:
        """Outcomes of the same tests in MuJoCo (``pip install mujoco``), a row for each grasp: ``id``, and ``stable`` (bool),
        ``stable_reason``, ``stable_displacement_m`` and ``stable_turn_rad`` as by :meth:`stability`.

        The numbers of the test, the joint targets, the shapes and the criteria are those of :meth:`stability`; the scenes are
        those of ``export(format="mujoco", protocol=…)``. The time step is a fraction of that of the test, 4 ms at most. Contacts are
        as stiff at rest as there, and joints have limits.

        Parameters
        ----------
        protocol
            As in :meth:`stability`.

        Raises
        ------
        InputError
            If MuJoCo is missing, the protocol is wrong, the hand has a skin that bends, or there are no grasps.
        """
        from ._mujoco import engine, outcomes

        engine()
        columns: list[dict[str, Any]] = []
        names = self.hand, self.object, self.column("scale")
        for hand, item, scale, _ in self.populations:
            of_this = (names[0] == hand) & (names[1] == item) & (names[2] == scale)
            folder = Folder()
            scene = self[of_this].export(folder / "scene", format="mujoco", protocol=protocol) / "scene.xml"
            table = outcomes(scene)
            columns.extend({name: values[row] for name, values in table.items()} for row in range(table.rows))
        found = {row["id"]: row for row in columns}
        return _columns([found[id] for id in self.id])

    def refine(
        self, n: int | None = None, *, perturb_mm: float | None = None, beyond: StrPath | Grasps | None = None,
        apart_mm: float | None = None, chance: float | None = None, seed: int = 0, keep: Keep = "strict",
        out: StrPath | None = None, force: bool = False, progress: bool | None = None,
    ) -> Grasps:
        """The minima to which descents from these grasps lead: the same bytes as ``landscape synth --from``.

        Parameters
        ----------
        n
            Number of chains; by default one for each grasp, and with ``beyond`` at most 256 more.
        perturb_mm
            How far each grasp is moved in a random direction first: root mean square movement of the hand's surface.
        beyond
            Grasps, or the path of a file or a landscape. Further chains look for grasps that it lacks, and these are added.
        apart_mm, chance, seed, keep, out, force, progress
            As in :func:`synthesize`.

        Raises
        ------
        InputError
            If an argument is wrong, these are not grasps of one hand on one object, or no chain passed the filter.
        KeyboardInterrupt
            On Ctrl-C, within a second.
        """
        folder = None if out is not None else Folder()
        target = Path(out) if folder is None else folder / "grasps.parquet"  # type: ignore[arg-type]
        words = flags(
            from_=self._file(), chains=whole_or_none("n", n), perturb=perturb_mm, seed=whole("seed", seed) or None,
            beyond=beyond._file() if isinstance(beyond, Grasps) else beyond, apart=apart_mm, chance=chance,
            keep=None if keep == "strict" else keep, force=force,
        )
        command("synth", *words, "--quiet", "--output", target, progress=progress)
        return Grasps(_native.Grasps.read(target, None, None), target, folder)

    def _remade(self, verb: str, given: list[str], out: StrPath | None, ending: str, progress: bool | None) -> Grasps:
        file = self._file()
        folder = None if out is not None else Folder()
        target = Path(out) if folder is None else folder / f"{file.stem}.{ending}.parquet"  # type: ignore[arg-type]
        command(verb, file, *given, "--quiet", "--output", target, progress=progress)
        return Grasps(_native.Grasps.read(target, None, None), target, folder)

    # Files of other programs, pages, landscapes

    def export(self, out: StrPath, *, format: str, protocol: Protocol | None = None, force: bool = False) -> Path:
        """Writes the grasps for other programs and returns the path.

        Parameters
        ----------
        out
            The file to write, or the folder for ``dexonomy``, ``mujoco``, ``urdf``, ``glb`` and ``usd``.
        format
            ``"csv"``, ``"json"``, ``"dexgraspnet"``, ``"dexonomy"``, ``"qpos"``, ``"mujoco"``, ``"isaac_grasp"``,
            ``"graspgen"``, ``"urdf"``, ``"glb"`` or ``"usd"``; ``command("help", "export")`` describes them.
        protocol
            The published test of a scene of ``mujoco``; by default that by which the grasps were simulated if the hand closes
            in it, and ``"dexgraspbench"`` otherwise.
        force
            Whether to replace a file that landscape did not write, or to write beside the files of others in a folder.

        Raises
        ------
        InputError
            If there is no such format, ``out`` has the wrong ending or belongs to others, or there are no grasps.
        """
        target = Path(out)
        command("export", self._file(), format, *flags(protocol=protocol, force=force), "--quiet", "--output", target, progress=False)
        return target

    def report(
        self, out: StrPath, *, by: StrPath | None = None, force: bool = False, progress: bool | None = None,
    ) -> Path:
        """Writes a page on which the grasps are looked at and labelled, and returns its path.

        Parameters
        ----------
        out
            The file to write (HTML).
        by, force, progress
            As in :meth:`label`. The page asks first for the grasps of which the labeller is least sure.

        Raises
        ------
        InputError
            If landscape did not write the file, the labeller cannot be used, or there are no grasps.
        """
        target = Path(out)
        command("report", self._file(), *flags(by=by, force=force), "--quiet", "--output", target, progress=progress)
        return target

    def show(self, *, by: StrPath | None = None, height_px: int = 720) -> Page:
        """The page of :meth:`report` as a widget of a notebook; needs ``anywidget``.

        Parameters
        ----------
        by
            As in :meth:`label`.
        height_px
            Height on the screen, pixels.

        Raises
        ------
        InputError
            If the labeller cannot be used, or there are no grasps.
        """
        from .widget import Page

        return Page.of(partial(self.report, by=by), height_px)

    def build(self, out: StrPath | None = None, **settings: Any) -> Landscape:
        """The landscape between these grasps.

        Parameters
        ----------
        out, settings
            As in :func:`build`, whose ``Raises`` and sources hold here, too.
        """
        from ._landscape import build

        return build(self, out, **settings)

    def __repr__(self) -> str:
        pairs = dict.fromkeys(f"{hand} on {object}" for hand, object, _, _ in self.populations)
        return f"{len(self)} grasps of {', '.join(pairs)}" if pairs else "0 grasps"


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    array.setflags(write=False)
    return array


def _state(file: Path | None) -> tuple[int, int] | None:
    """What tells that a file was not changed."""
    if file is None or not file.is_file():
        return None
    state = file.stat()
    return (state.st_mtime_ns, state.st_size)


class Energy:
    """The energy of a hand on an object, for many poses at once and on all cores.

    Parameters
    ----------
    hand, object
        What it is the energy of.

    Raises
    ------
    InputError
        If an argument is not a hand or an object.
    """

    def __init__(self, hand: Hand, object: Object) -> None:
        instance("hand", hand, Hand)
        instance("object", object, Object)
        self._object = object
        self._native = _native.Energy(hand._native, object._native)

    @property
    def term_names(self) -> list[str]:
        """Names of the terms, in their order in files."""
        return self._native.term_names

    @property
    def settings(self) -> dict[str, Any]:
        """All constants of the energy."""
        made: dict[str, Any] = json.loads(self._native.settings)
        return made

    def __call__(self, grasps: Grasps | ArrayLike) -> Evaluation:
        """Energies, gradients and terms.

        Parameters
        ----------
        grasps
            Grasps of this hand on this object, or poses of shape (n, 7 + joints) as in :attr:`Grasps.poses`: position (m), unit
            quaternion w, x, y, z, joints (rad).

        Returns
        -------
        Evaluation
            Energies are +inf outside the domain. No number is NaN.

        Raises
        ------
        InputError
            If a number is not finite, or the length of a quaternion differs from 1 by more than 1e-3 (smaller differences are
            scaled away): the sentence names the row. Also if the grasps are of another hand, of another object, or of the
            object at another scale.
        """
        poses = self._poses(grasps)
        energy, gradient = self._native.evaluate(poses)
        terms = self._native.terms(poses)
        return Evaluation(energy, gradient, {name: terms[:, place] for place, name in enumerate(self.term_names)})

    def evaluate(self, grasps: Grasps | ArrayLike) -> tuple[Floats, Floats]:
        """Energies, shape (n,), and gradients, shape (n, tangents), without the terms, with which a call takes four times as
        long in all.

        Parameters
        ----------
        grasps
            As in a call of the energy. The derivatives are those of :class:`Evaluation`.

        Raises
        ------
        InputError
            As in a call of the energy.
        """
        return self._native.evaluate(self._poses(grasps))

    def moved(self, poses: ArrayLike, tangents: ArrayLike) -> Floats:
        """Poses moved along tangents, shape (n, 7 + joints): by the exponential map, in which gradients are derivatives.

        Parameters
        ----------
        poses
            Shape (n, 7 + joints), as in :attr:`Grasps.poses`.
        tangents
            Shape (n, tangents), in the units of :class:`Evaluation`.

        Raises
        ------
        InputError
            If a shape or a number is wrong, as in a call of the energy.
        """
        return self._native.moved(poses, tangents)

    def _poses(self, grasps: Grasps | ArrayLike) -> Any:
        if not isinstance(grasps, Grasps):
            return grasps
        name, scale = self._object.name, self._object.scale
        names, scales = grasps.object, grasps.column("scale")
        other = np.flatnonzero((names != name) | (scales != scale))
        if other.size:
            row = int(other[0])
            raise InputError(
                f"grasps: row {row} is of the object {names[row]!r} at scale {scales[row]}, but the energy is of {name!r} at "
                f"scale {scale}"
            )
        return self._native.poses(grasps._native)


def synthesize(
    hand: Hand,
    object: Object,
    n: int | None = None,
    *,
    seed: int = 0,
    keep: Keep = "strict",
    steps: int | None = None,
    spread: int | None = None,
    types: Sequence[int | str] | None = None,
    cells: Sequence[str] | None = None,
    grips: Sequence[str] | None = None,
    regions: Sequence[Sequence[str]] | None = None,
    beyond: StrPath | Grasps | None = None,
    apart_mm: float | None = None,
    chance: float | None = None,
    config: StrPath | None = None,
    out: StrPath | None = None,
    force: bool = False,
    progress: bool | None = None,
) -> Grasps:
    """Grasps of a hand on an object by differentiable force closure: the same bytes as ``landscape synth``.

    After T. Liu, Z. Liu, Z. Jiao, Y. Zhu and S.-C. Zhu, IEEE Robot. Autom. Lett. 7, 470 (2022), arXiv:2104.09194.

    Parameters
    ----------
    hand, object
        Who grasps what.
    n
        Number of chains, each of which gives one grasp at most; 64 by default.
    seed
        Seed of all random draws. The result depends on nothing else: neither on threads nor on interruptions.
    keep
        ``"strict"`` (what a person could hold), ``"published"`` (Eq. 11 of Liu et al. 2021) or ``"all"``.
    steps, spread
        Descents of a chain at most, and how many grasps to keep at most, spread over the object.
    types, cells
        Grasp types to ask for, by number (1 to 33) or name, and cells of the taxonomy (``"precision/pad/2/abducted"``). Chains
        serve all wishes in turn, and an end counts only if it is what was asked for.
    grips
        Sets of digits to ask for, such as ``["thumb+index", "thumb+index+middle"]``; no other digit touches.
    regions
        Sets of regions of the hand to ask for, such as ``[["thumb.distal.pad", "index.distal.pad"]]``.
    beyond
        Grasps, or the path of a file or a landscape: only grasps that it lacks are kept.
    apart_mm, chance
        With ``beyond``: least distance of a new grasp from all others (5 mm), and the chance that one more end is new below
        which the search ends (0.1).
    config
        An experiment file (TOML).
    out
        The file to write. An interrupted call with the same ``out`` goes on where it stopped. By default none is kept.
    force
        Whether to replace a file that landscape did not write.
    progress
        Whether to show a progress bar; by default if standard error is a terminal.

    Raises
    ------
    InputError
        If an argument is wrong, or no chain passed the filter.
    KeyboardInterrupt
        On Ctrl-C, within a second.
    """
    folder = None if out is not None else Folder()
    target = Path(out) if folder is None else folder / "grasps.parquet"  # type: ignore[arg-type]
    words = flags(
        chains=whole_or_none("n", n), steps=whole_or_none("steps", steps),
        seed=whole("seed", seed) or None, force=force, config=config,
        keep=None if keep == "strict" else keep, spread=whole_or_none("spread", spread),
        types=types and list(types), cells=cells and list(cells), grips=grips and list(grips),
        beyond=beyond._file() if isinstance(beyond, Grasps) else beyond, apart=apart_mm, chance=chance,
    )
    for part in regions or ():
        words += flags(regions=list(part))
    synthesized(hand, object, target, progress, words)
    return Grasps(_native.Grasps.read(target, None, None), target, folder)


def import_grasps(
    path: StrPath,
    hand: Hand,
    object: Object,
    *,
    mapping: StrPath | None = None,
    out: StrPath | None = None,
    force: bool = False,
    progress: bool | None = None,
) -> Grasps:
    """Grasps of another program: the same bytes as ``landscape import``.

    Formats: DexGraspNet (R. Wang et al., ICRA 2023), DexGraspBench and BODex (J. Chen et al., ICRA 2025), Dexonomy (J. Chen et
    al., RSS 2025), graspqp, MultiDex and DRO-Grasp (``.pt``), ``isaac_grasp`` (``.yaml``), GraspGen (``.json``), ACRONYM
    (``.h5``, with the package ``h5py``), arrays of ``qpos``, and tables; ``docs/import_export.md`` describes them. If the
    grasps lie beside the object, a :class:`UserWarning` names the unit, order or frame that would fit.

    ACRONYM's poses are those of the base of the Panda hand, whose fingertips are at x ±0.041 m, z 0.112 m; all its grasps have
    the joints of ``gripper/configuration``, which is the open hand. Grasps that failed there are kept, too.

    Parameters
    ----------
    path
        The file or folder.
    hand, object
        Who grasps what in it.
    mapping
        A TOML file that tells what its columns or arrays mean.
    out
        The file to write; by default none is kept.
    force
        Whether to replace a file that landscape did not write.
    progress
        Whether to show a progress bar; by default if standard error is a terminal.

    Raises
    ------
    InputError
        If the file is of no known format, does not fit the hand, or holds no grasps, or if these are more than half a metre
        from the object.
    FileNotFoundError
        If there is no such file.
    """
    instance("hand", hand, Hand)
    instance("object", object, Object)
    folder = None if out is not None else Folder()
    target = Path(out) if folder is None else folder / "grasps.parquet"  # type: ignore[arg-type]
    given = existing(path)
    if given.suffix.lower() in ENDINGS:
        if mapping is not None:
            raise InputError("mapping: the meaning of a file of ACRONYM is known; leave the mapping out")
        converted = Folder()
        given, mapping = as_table(given, hand.joint_names, converted / ".")
    words = [*hand._flags(named=True), *object._flags(), *flags(mapping=mapping, force=force)]
    command("import", given, *words, "--quiet", "--output", target, progress=progress)
    grasps = Grasps(_native.Grasps.read(target, None, None), target, folder)
    if "doubt" in grasps.metadata["settings"]:
        warnings.warn(grasps.metadata["settings"]["doubt"], stacklevel=2)
    return grasps


def _files(sets: Sequence[Grasps | StrPath], folder: Folder) -> list[Path]:
    """Files of sets of grasps; those that are in memory only are written into a folder."""
    return [
        each._file(folder / f"set_{place}.parquet") if isinstance(each, Grasps) else existing(each)
        for place, each in enumerate(sets, 1)
    ]


def join(*sets: Grasps | StrPath, out: StrPath | None = None, force: bool = False) -> Grasps:
    """Several sets of grasps as one, in their order: the same bytes as ``landscape join``.

    Ids are new, from 0; the column ``source`` names file and id before.

    Parameters
    ----------
    sets
        Grasps and their files, two or more. Grasps that are in memory only are called ``set_1.parquet``, ``set_2.parquet``, …
        by their place among the arguments.
    out
        The file to write; by default none is kept.
    force
        Whether to replace a file that landscape did not write.

    Raises
    ------
    InputError
        If hands or objects of one name differ, or the energies do.
    FileNotFoundError
        If there is no such file.
    """
    folder = Folder()
    target = folder / "joined.parquet" if out is None else Path(out)
    paths = _files(sets, folder)
    command("join", *paths, *flags(force=force), "--quiet", "--output", target, progress=False)
    return Grasps(_native.Grasps.read(target, None, None), target, folder if out is None else None)


@dataclass(frozen=True)
class Labeller:
    """A labeller that :func:`learn` taught. :meth:`Grasps.label` and :meth:`Grasps.report` take it, or its file, as ``by``."""

    path: Path
    """Its file."""
    labels: dict[str, int]
    """Number of labels of each type that it has seen."""
    tested_on_left_out: str
    """What was left out at a time to judge it: ``"objects"``, or ``"grasps"`` where there are fewer than three objects."""
    judged: Table
    """How often it is right about what was left out, a row each for category, cell and type: ``name``, ``labeller_share``,
    ``rule_share``, ``commonest_share`` (the type that is the commonest), ``gain_share`` (labeller less rule), 95 % intervals
    of shape (3, 2) (``gain_interval_share`` and so on), and ``calibration_error``. It is shown that the labeller is better
    than the rule where the interval of the gain lies above 0."""
    certainties: Table
    """What ``likely``, ``open`` and ``a guess`` are worth: ``name``, ``certainty``, ``answers``, ``right_share``."""

    def __fspath__(self) -> str:
        return str(self.path)


def _columns(rows: list[dict[str, Any]]) -> Table:
    """Rows of a document as columns."""
    names = rows[0] if rows else {}
    columns = {name: [row[name] for row in rows] for name in names}
    return Table({
        name: values if isinstance(values[0], str) else np.array(values) for name, values in columns.items()
    })


def learn(
    grasps: Grasps | StrPath | Sequence[Grasps | StrPath],
    out: StrPath,
    *,
    labels: StrPath | None = None,
    rule: StrPath | None = None,
    force: bool = False,
    progress: bool | None = None,
) -> Labeller:
    """Teaches a labeller by grasps that a person labelled: the same bytes as ``landscape label --learn``.

    Parameters
    ----------
    grasps
        Grasps with labels (column ``label``), or their file, or a list of these. It takes thirty labels; a hundred of ten
        objects teach much more.
    out
        The file to write, usually with the ending ``.labeller``.
    labels
        A CSV file with your labels (columns ``id`` and ``label``), which override those of the grasps.
    rule
        A file with another rule than the standard one; :meth:`Grasps.label` then needs the same.
    force
        Whether to replace a file that landscape did not write.
    progress
        Whether to show a progress bar; by default if standard error is a terminal.

    Raises
    ------
    InputError
        If there are fewer than thirty labels, all are the same, or a file is wrong.
    FileNotFoundError
        If there is no such file.
    """
    folder, target = Folder(), Path(out)
    sets = [grasps] if isinstance(grasps, (Grasps, str, os.PathLike)) else grasps
    paths = _files(sets, folder)
    given = flags(from_=labels, rule=rule, force=force)
    told = command("label", "--learn", *paths, *given, "--quiet", "--json", "--output", target, progress=progress)
    found = json.loads(told)
    return Labeller(
        target, found["labels"], found["tested_on_left_out"], _columns(found["judged"]), _columns(found["certainties"])
    )
