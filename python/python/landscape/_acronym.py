"""Files of ACRONYM (C. Eppner et al., ICRA 2021) as tables that ``landscape import`` reads."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ._errors import InputError

#: Endings of HDF5 files.
ENDINGS = (".h5", ".hdf5")
#: What is read of a file.
DATA_SETS = ("grasps/transforms", "gripper/configuration", "object/scale")


def _rows(file: Any, joints: int) -> dict[str, Any]:
    """Pose, joints and scale of each grasp. ``object_from_gripper`` is written as a matrix, row by row."""
    for name in DATA_SETS:
        if name not in file:
            raise InputError(f"it has no {name}, so it is no file of ACRONYM")
    transforms = np.asarray(file["grasps/transforms"], dtype=float)
    if transforms.ndim != 3 or transforms.shape[1:] != (4, 4):
        raise InputError(f"its grasps/transforms have the shape {transforms.shape}, but (n, 4, 4) is needed")
    opening = np.ravel(np.asarray(file["gripper/configuration"], dtype=float)).tolist()
    if len(opening) == 1:
        # The fingers of a parallel gripper move alike.
        opening *= joints
    if len(opening) != joints:
        raise InputError(f"its gripper/configuration has {len(opening)} numbers, but the hand has {joints} joints")
    scale = float(np.asarray(file["object/scale"]))
    grasps = [
        {"position": pose[:3, 3].tolist(), "rotation": pose[:3, :3].ravel().tolist(), "joints": opening, "scale": scale}
        for pose in transforms
    ]
    return {"grasps": grasps}


#: What the columns of :func:`_rows` mean.
MAPPING = 'translation = "position"\nrotation = "rotation"\nrotation_form = "matrix"\n'


def as_table(path: Path, joints: list[str], folder: Path) -> tuple[Path, Path]:
    """The grasps of ``path`` as a table in ``folder``, and its mapping. ``joints`` are the names of the hand's joints."""
    try:
        import h5py
    except ImportError:
        raise InputError(f"{path}: reading HDF5 needs h5py: pip install h5py") from None
    try:
        with h5py.File(path, "r") as file:
            table = _rows(file, len(joints))
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error}") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    rows, mapping = folder / f"{path.stem}.json", folder / "acronym.toml"
    rows.write_text(json.dumps(table))
    mapping.write_text(f"{MAPPING}joint_names = {json.dumps(joints)}\n")
    return rows, mapping
