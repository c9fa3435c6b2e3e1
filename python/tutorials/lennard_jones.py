"""Lennard-Jones clusters by a numpy function and by an ASE calculator, and a picture of the disconnectivity graph.

python lennard_jones.py [FOLDER]    writes FOLDER/lennard_jones.svg
"""

import sys
from pathlib import Path

import ase
import numpy as np
from ase.calculators.lj import LennardJones

import landscape as ls

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")


def lennard_jones(x):
    """Energy and gradient of equal atoms, shape (3 n,), in units of ε and σ."""
    r = x.reshape(-1, 3)
    d = r[:, None] - r[None]
    s = (d**2).sum(-1) + np.eye(len(r))
    i6 = s**-3
    np.fill_diagonal(i6, 0)
    return 2 * (i6**2 - i6).sum(), ((-24 * (2 * i6**2 - i6) / s)[..., None] * d).sum(1).ravel()


# Seven atoms have four minima (C. J. Tsai and K. D. Jordan, J. Phys. Chem. 97, 11227 (1993)).
# A small patience ends the search soon after the last new minimum.
seven = ls.explore(lennard_jones, ls.Atoms(7), box=(-1.2, 1.2), seed=0, patience=4)
print(seven.minima.energy)
print(seven.saddles[["a", "b", "energy"]].to_pandas())
assert seven.minima.rows == 4
way = seven.path(0, 1)
print(f"from the lowest minimum to the next: up to {way.height:.4f} over a path of {way.length[-1]:.2f} σ")
seven.draw(folder / "lennard_jones.svg", levels=20)

# The same energy by a calculator. Its cutoff is far outside the cluster.
atoms = ase.Atoms("Ar4", positions=np.random.default_rng(0).normal(size=(4, 3)))
four = ls.explore(ls.from_ase(atoms, LennardJones(rc=50.0)), box=(-1.0, 1.0), patience=4)
assert abs(four.minima.energy[0] + 6) < 1e-3
print(f"four atoms: {four.minima.energy[0]:.4f}")
