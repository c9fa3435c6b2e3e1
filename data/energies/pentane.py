"""Torsions of n-pentane, as an energy for `landscape surface --command`; see docs/tutorials/pentane.md.

The two coordinates are the dihedral angles along the chain of five carbon atoms, in radians, with trans at π. Bonds and angles
are rigid. Energies are in kJ/mol, from the united atoms of M. G. Martin and J. I. Siepmann, J. Phys. Chem. B 102, 2569 (1998).
"""

import json
import math
import sys

KELVIN = 0.00831446
TORSION = [355.03 * KELVIN, -68.19 * KELVIN, 791.32 * KELVIN]
EPSILON, SIGMA = 98.0 * KELVIN, 3.75
BOND, ANGLE = 1.54, math.radians(114.0)


def torsion(phi):
    """Energy of one dihedral angle, and its derivative."""
    a, b, c = TORSION
    energy = a * (1 + math.cos(phi)) + b * (1 - math.cos(2 * phi)) + c * (1 + math.cos(3 * phi))
    return energy, -a * math.sin(phi) + 2 * b * math.sin(2 * phi) - 3 * c * math.sin(3 * phi)


def end(phi, side):
    """Place of one end of the chain, and its derivative by the dihedral angle. The middle atom is at 0, its bonds in a plane."""
    half = ANGLE / 2
    # Along the bond of this side, and across it towards the other bond.
    along, across = (side * math.sin(half), math.cos(half)), (-side * math.cos(half), math.sin(half))
    reach, width = BOND - BOND * math.cos(ANGLE), BOND * math.sin(ANGLE)
    cosine, sine = width * math.cos(phi), width * math.sin(phi)
    place = [reach * along[k] + cosine * across[k] for k in (0, 1)] + [side * sine]
    slope = [-sine * across[k] for k in (0, 1)] + [side * cosine]
    return place, slope


def energy_and_gradient(first, second):
    (energy_1, slope_1), (energy_2, slope_2) = torsion(first), torsion(second)
    (p, dp), (q, dq) = end(first, 1), end(second, -1)
    d = [a - b for a, b in zip(p, q)]
    square = sum(v * v for v in d)
    six = (SIGMA * SIGMA / square) ** 3
    contact = 4 * EPSILON * (six * six - six)
    # Derivative by the squared distance.
    push = 4 * EPSILON * (-6 * six * six + 3 * six) / square
    along_1 = 2 * push * sum(a * b for a, b in zip(d, dp))
    along_2 = -2 * push * sum(a * b for a, b in zip(d, dq))
    return energy_1 + energy_2 + contact, [slope_1 + along_1, slope_2 + along_2]


if __name__ == "__main__":
    for line in sys.stdin:
        energy, gradient = energy_and_gradient(*json.loads(line)["x"])
        print(json.dumps({"energy": energy, "gradient": gradient}), flush=True)
