"""Hands and objects."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._call import Folder, StrPath, command, flags
from ._checks import instance, magnitude_or_none, numbers
from ._errors import InputError


class Hand:
    """A hand: its links, joints and surface.

    Parameters
    ----------
    name_or_file
        The name of a hand that comes with the package (``landscape.HAND_NAMES``), or a URDF, MJCF or MANO (``.npz``) file.
    folder
        The folder with all files that the description refers to; by default that of the file. Others are refused.
    mirror
        Takes the mirror image: a left hand from a right one.

    Raises
    ------
    InputError
        If there is no such hand, or its files are wrong.
    """

    def __init__(self, name_or_file: StrPath, *, folder: StrPath | None = None, mirror: bool = False) -> None:
        self._given = os.fspath(name_or_file)
        self._folder = None if folder is None else Path(folder)
        self._mirror = mirror
        self._native = _native.Hand(self._given, self._folder, mirror)

    def _flags(self, *, named: bool = False) -> list[str]:
        """The flags that tell this hand. The default hand has no name there, unless it must be ``named``."""
        given = self._given if named or self._given != "human" else None
        return flags(hand=given, hand_folder=self._folder, mirror=self._mirror)

    @property
    def name(self) -> str:
        """Its name in files."""
        return self._native.name

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints, in the order of ``joints``."""
        return self._native.joint_names

    @property
    def limits(self) -> NDArray[np.float64]:
        """Lower and upper limits of the joints, shape (joints, 2), radians; metres for sliding joints."""
        return self._native.limits

    @property
    def link_names(self) -> list[str]:
        """Names of the links, in the order of :meth:`link_frames`."""
        return self._native.link_names

    @property
    def digits(self) -> list[str]:
        """Names of the palm and the digits."""
        return self._native.digits

    @property
    def notes(self) -> list[str]:
        """What was noted when the description was read, one sentence each."""
        return self._native.notes

    @property
    def rest_pose(self) -> NDArray[np.float64]:
        """The pose at the origin with the joints at rest, shape (7 + joints,): position (m), quaternion w, x, y, z, joints."""
        return self._native.rest_pose

    def link_frames(self, pose: ArrayLike) -> NDArray[np.float64]:
        """Frames of all links in a pose, shape (links, 4, 4): matrices from link to object, metres.

        Parameters
        ----------
        pose
            A row of :attr:`Grasps.poses`: position (m), unit quaternion w, x, y, z, joints (rad), shape (7 + joints,).

        Raises
        ------
        InputError
            If the shape is wrong, a number is not finite, or the length of the quaternion differs from 1 by more than 1e-3.
        """
        return self._native.link_frames(pose)

    def surface_points(self, pose: ArrayLike) -> NDArray[np.float64]:
        """Points on the surface of the hand in a pose, shape (points, 3), metres, in the frame of the object.

        Contacts of grasps are indices of these points.

        Parameters
        ----------
        pose
            As in :meth:`link_frames`.

        Raises
        ------
        InputError
            As in :meth:`link_frames`.
        """
        return self._native.surface_points(pose)

    @property
    def surface_links(self) -> NDArray[np.int64]:
        """The link of each surface point, shape (points,)."""
        return self._native.surface_links()

    def __repr__(self) -> str:
        return f"Hand {self.name!r} with {len(self.joint_names)} joints"


class Object:
    """An object that is grasped.

    Parameters
    ----------
    name_or_file
        The name of an object that comes with the package (``landscape.OBJECT_NAMES``), a mesh (OBJ, STL, PLY, glTF), or a
        TOML file of shapes.
    scale
        Metres per unit of the mesh: 0.001 for millimetres. From a millionth to a million.
    name
        Its name in files and pictures, instead of the name of the file.
    thickness_mm
        Makes open surfaces of the mesh, such as a sheet or a cup without walls, walls of this many millimetres.

    Raises
    ------
    InputError
        If there is no such object, its mesh cannot be closed, or there is no open surface to thicken.
    """

    def __init__(
        self,
        name_or_file: StrPath,
        *,
        scale: float | None = None,
        name: str | None = None,
        thickness_mm: float | None = None,
    ) -> None:
        self._given = os.fspath(name_or_file)
        self._scale, self._name, self._thickness_mm = scale, name, thickness_mm
        self._keeps: Folder | None = None
        factor = magnitude_or_none("scale", scale)
        thickness_mm = magnitude_or_none("thickness_mm", thickness_mm)
        self._native = _native.Object(self._given, 1.0 if factor is None else factor, name, thickness_mm)

    @classmethod
    def from_mesh(
        cls,
        vertices: ArrayLike,
        triangles: ArrayLike,
        *,
        name: str = "object",
        scale: float | None = None,
        thickness_mm: float | None = None,
    ) -> Object:
        """An object from a mesh in memory.

        Parameters
        ----------
        vertices
            Shape (n, 3), metres unless ``scale`` is given.
        triangles
            Indices of vertices, shape (m, 3), from 0.
        name
            Its name in files and pictures.
        scale
            Metres per unit of the vertices; 1 by default.
        thickness_mm
            As for a file.

        Raises
        ------
        InputError
            If a shape or a number is wrong, or the mesh cannot be closed.
        """
        points = numbers("vertices", vertices)
        try:
            corners = np.asarray(triangles)
        except ValueError:
            raise InputError("triangles: an array of whole numbers is needed, with rows of equal length") from None
        if points.ndim != 2 or points.shape[1] != 3:
            raise InputError(f"vertices have the shape {points.shape}, but (n, 3) is needed")
        if corners.ndim != 2 or corners.shape[1] != 3 or not np.issubdtype(corners.dtype, np.integer):
            raise InputError(f"triangles must be whole numbers of the shape (m, 3), but are {corners.dtype} of {corners.shape}")
        if not name.strip() or any(mark in "/\\" or not mark.isprintable() for mark in name):
            raise InputError(f"name {name!r}: a name without slashes and marks that are not shown is needed")
        folder = Folder()
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in corners.tolist()]
        file = folder / f"{name}.obj"
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")
        made = cls(file, scale=scale, thickness_mm=thickness_mm)
        made._keeps = folder
        return made

    @classmethod
    def from_trimesh(cls, mesh: object, *, name: str = "object", scale: float | None = None) -> Object:
        """An object from a ``trimesh.Trimesh``.

        Parameters
        ----------
        mesh
            The mesh, in metres unless ``scale`` is given.
        name, scale
            As in :meth:`from_mesh`.

        Raises
        ------
        InputError
            As in :meth:`from_mesh`.
        """
        return cls.from_mesh(mesh.vertices, mesh.faces, name=name, scale=scale)  # type: ignore[attr-defined]

    def _flags(self) -> list[str]:
        """The flags that name this object."""
        return flags(object=self._given, scale=self._scale, name=self._name, thickness=self._thickness_mm)

    @property
    def name(self) -> str:
        """Its name in files."""
        return self._native.name

    @property
    def scale(self) -> float:
        """Metres per unit of its mesh."""
        return self._native.scale

    @property
    def mass_kg(self) -> float:
        """Mass, kilograms."""
        return self._native.mass_kg

    @property
    def radius_m(self) -> float:
        """Largest distance of a vertex from the centroid, metres."""
        return self._native.radius_m

    @property
    def notes(self) -> list[str]:
        """What was repaired or is doubtful, one sentence each."""
        return self._native.notes

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Vertices of the mesh, shape (n, 3), metres."""
        return self._native.vertices

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """Triangles of the mesh as indices of vertices, shape (m, 3)."""
        return self._native.triangles

    def distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """Exact signed distances from the surface, shape (n,): metres, negative inside.

        Parameters
        ----------
        points
            Points in the frame of the object, shape (n, 3), metres.

        Raises
        ------
        InputError
            If the shape is wrong or a number is not finite.
        """
        return self._native.distance(points)

    def __repr__(self) -> str:
        return f"Object {self.name!r} at scale {self.scale}"


def synthesized(
    hand: Hand,
    object: Object,
    out: Path,
    progress: bool | None,
    words: list[str],
) -> None:
    """Runs ``landscape synth``."""
    instance("hand", hand, Hand)
    instance("object", object, Object)
    command("synth", *hand._flags(), *object._flags(), *words, "--quiet", "--output", out, progress=progress)
