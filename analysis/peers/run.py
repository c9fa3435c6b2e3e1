"""landscape beside topsearch (and pele, where it can be installed) on the same surfaces -> figures/peers.md

    python3 -m venv peers && peers/bin/pip install topsearch==0.0.3 "numpy<2" scipy
    cargo build --release
    python3 -m venv pele && pele/bin/pip install pele==0.1.2
    peers/bin/python analysis/peers/run.py target/release/landscape pele/bin/python

Each program runs alone, on one thread, with the settings of its own examples. On the two functions of two coordinates both
call the same Python code, so the numbers of calls can be compared. Their stationary points are known: Newton's method from
every point of a fine grid finds all roots of the gradient. On clusters the references are the published counts.
"""

import json
import math
import os
import subprocess
import sys
import tempfile
import time

import numpy as np

OUTPUT = "figures/peers.md"
# Seconds after which a peer is stopped.
LIMIT = 900
SAME = 1e-3


class MullerBrown:
    """Three minima and two saddles; K. Müller and L. D. Brown, Theor. Chim. Acta 53, 75 (1979)."""

    name = "Müller–Brown"
    bounds = [(-1.5, 1.0), (-0.3, 1.8)]
    height = np.array([-200.0, -100.0, -170.0, 15.0])
    a = np.array([-1.0, -1.0, -6.5, 0.7])
    b = np.array([0.0, 0.0, 11.0, 0.6])
    c = np.array([-10.0, -10.0, -6.5, 0.7])
    x0 = np.array([1.0, 0.0, -0.5, -1.0])
    y0 = np.array([0.0, 0.5, 1.5, 1.0])

    def value_and_slope(self, x):
        dx, dy = x[0] - self.x0, x[1] - self.y0
        value = self.height * np.exp(self.a * dx * dx + self.b * dx * dy + self.c * dy * dy)
        slope = [np.sum(value * (2 * self.a * dx + self.b * dy)), np.sum(value * (self.b * dx + 2 * self.c * dy))]
        return float(np.sum(value)), np.array(slope)


class Fourier:
    """Waves of random direction in a bowl, so steep at its edge that all stationary points lie inside the bounds."""

    name = "Fourier, two coordinates"
    bounds = [(-4.0, 4.0), (-4.0, 4.0)]

    def __init__(self, seed=5, waves=12):
        rng = np.random.default_rng(seed)
        self.k = rng.normal(size=(waves, 2)) * 2.0
        self.phase = rng.uniform(0, 2 * math.pi, waves)
        self.amplitude = rng.normal(size=waves)

    def value_and_slope(self, x):
        angle = self.k @ x + self.phase
        square = x @ x
        value = float(self.amplitude @ np.cos(angle) + 0.1 * square * square)
        return value, -(self.amplitude * np.sin(angle)) @ self.k + 0.4 * square * x


def hessian(surface, x, step=1e-5):
    rows = []
    for k in range(2):
        e = np.zeros(2)
        e[k] = step
        rows.append((surface.value_and_slope(x + e)[1] - surface.value_and_slope(x - e)[1]) / (2 * step))
    h = np.array(rows)
    return 0.5 * (h + h.T)


def all_points(surface, grid=121):
    """Energies of all minima and all saddles in the bounds, by Newton's method from a grid."""
    found = []
    sides = [np.linspace(low, high, grid) for low, high in surface.bounds]
    for start in np.array(np.meshgrid(*sides)).reshape(2, -1).T:
        x = start.copy()
        for _ in range(40):
            slope = surface.value_and_slope(x)[1]
            h = hessian(surface, x)
            if abs(np.linalg.det(h)) < 1e-12:
                break
            step = np.linalg.solve(h, slope)
            if np.linalg.norm(step) > 0.3:
                break
            x = x - step
            if np.linalg.norm(step) < 1e-10:
                break
        inside = all(low <= v <= high for v, (low, high) in zip(x, surface.bounds))
        if not inside or np.linalg.norm(surface.value_and_slope(x)[1]) > 1e-6:
            continue
        if not any(np.linalg.norm(x - y) < SAME for y, _, _ in found):
            found.append((x, surface.value_and_slope(x)[0], int(np.sum(np.linalg.eigvalsh(hessian(surface, x)) < 0))))
    return [sorted((p for p in found if p[2] == index), key=lambda p: p[1]) for index in (0, 1)]


def compared(found, known):
    """How many known points were found, and how many found points are none."""
    right = sum(any(np.linalg.norm(np.array(x) - k[0]) < 10 * SAME for x in found) for k in known)
    false = sum(not any(np.linalg.norm(np.array(x) - k[0]) < 10 * SAME for k in known) for x in found)
    return f"{right} of {len(known)}" + (f", and {false} that are none" if false else "")


def ours(binary, surface):
    """The surface as a program of its own, searched by landscape."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out")
        region = ",".join(f"{low}:{high}" for low, high in surface.bounds)
        command = f"{sys.executable} {os.path.abspath(__file__)} --serve {type(surface).__name__}"
        arguments = [binary, "surface", "--command", command, f"--region={region}", "--protocol", "binary",
                     "--threads", "1", "-q", "--no-report", "-o", out]
        started = time.perf_counter()
        subprocess.run(arguments, check=True, cwd=folder)
        seconds = time.perf_counter() - started
        manifest = json.load(open(os.path.join(out, "landscape.json")))
        tables = [np.frombuffer(open(os.path.join(out, name), "rb").read()) for name in ("points.min", "points.ts")]
        points = [list(t.reshape(-1, 2)) for t in tables]
        return points, manifest["counts"]["evaluations"], seconds


def serve(name):
    surface = {"MullerBrown": MullerBrown, "Fourier": Fourier}[name]()
    while True:
        data = sys.stdin.buffer.read(16)
        if len(data) < 16:
            return
        value, slope = surface.value_and_slope(np.frombuffer(data))
        sys.stdout.buffer.write(np.array([value, *slope]).tobytes())
        sys.stdout.buffer.flush()


PEER = r'''
import json, sys, time, numpy as np
sys.path.insert(0, {here!r})
import run
from topsearch.data.coordinates import {coordinates}
from topsearch.data.kinetic_transition_network import KineticTransitionNetwork
from topsearch.global_optimisation.perturbations import {step}
from topsearch.global_optimisation.basin_hopping import BasinHopping
from topsearch.sampling.exploration import NetworkSampling
from topsearch.transition_states.hybrid_eigenvector_following import HybridEigenvectorFollowing
from topsearch.transition_states.nudged_elastic_band import NudgedElasticBand
{body}
ktn = KineticTransitionNetwork()
np.random.seed(0)
optimiser = BasinHopping(ktn=ktn, potential=potential, similarity=comparer, step_taking=step_taking)
hef = HybridEigenvectorFollowing(potential=potential, {hef})
neb = NudgedElasticBand(potential=potential, {neb})
explorer = NetworkSampling(ktn=ktn, coords=coords, global_optimiser=optimiser, single_ended_search=hef,
                           double_ended_search=neb, similarity=comparer)
explorer.get_minima(coords, {steps}, 1e-5, {temperature}, test_valid=True)
explorer.get_transition_states('ClosestEnumeration', {cycles}, remove_bounds_minima={remove})
minima = [list(map(float, ktn.get_minimum_coords(i))) for i in range(ktn.n_minima)]
states = [list(map(float, ktn.get_ts_coords(*edge[:2]))) for edge in ktn.G.edges]
energies = [[float(ktn.get_minimum_energy(i)) for i in range(ktn.n_minima)],
            [float(ktn.get_ts_energy(*edge[:2])) for edge in ktn.G.edges]]
print("RESULT " + json.dumps([minima, states, energies, calls]))
'''

FUNCTION = '''
from topsearch.potentials.potential import Potential
from topsearch.similarity.similarity import StandardSimilarity
surface = run.{surface}()
calls = 0
class Wrapped(Potential):
    def __init__(self):
        self.atomistic = False
    def function(self, x):
        global calls
        calls += 1
        return surface.value_and_slope(x)[0]
    def gradient(self, x):
        global calls
        calls += 1
        return surface.value_and_slope(x)[1]
    def function_gradient(self, x):
        global calls
        calls += 1
        return surface.value_and_slope(x)
potential = Wrapped()
coords = StandardCoordinates(ndim=2, bounds=surface.bounds)
comparer = StandardSimilarity(distance_criterion=0.01, energy_criterion=1e-2, proportional_distance=True)
step_taking = StandardPerturbation(max_displacement=1.0, proportional_distance=True)
'''

CLUSTER = '''
from topsearch.potentials.atomic import LennardJones
from topsearch.similarity.molecular_similarity import MolecularSimilarity
calls = 0
potential = LennardJones()
position = np.array([[0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, 0], [0, 0, 3], [0, 3, 3], [3, 3, 3]], float)
coords = AtomicCoordinates(atom_labels=['C'] * 7, position=position.flatten(), bond_cutoff=1.5)
comparer = MolecularSimilarity(distance_criterion=0.1, energy_criterion=5e-2, weighted=False)
step_taking = AtomicPerturbation(max_displacement=0.5, max_atoms=3)
'''


PELE = r'''
import json, time, numpy as np
np.random.seed(0)
from pele.systems import LJCluster
from pele.landscape import ConnectManager
system = LJCluster({atoms})
database = system.create_database()
system.get_basinhopping(database=database, outstream=None).run({hops})
manager = ConnectManager(database, strategy="gmin")
for _ in range(1000):
    try:
        pair = manager.get_connect_job()
    except Exception:
        break
    try:
        system.get_double_ended_connect(*pair, database, verbosity=0).connect()
    except Exception:
        pass
print("RESULT " + json.dumps([database.number_of_minima(), database.number_of_transition_states()]))
'''


def peer(script, python=sys.executable):
    """Runs a peer in a process of its own: its result and the seconds, or what went wrong."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "peer.py")
        open(path, "w").write(script)
        started = time.perf_counter()
        try:
            run = subprocess.run([python, path], cwd=folder, capture_output=True, text=True, timeout=LIMIT,
                                 env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"})
        except subprocess.TimeoutExpired:
            return None, f"stopped after {LIMIT} s"
        seconds = time.perf_counter() - started
        for line in run.stdout.splitlines():
            if line.startswith("RESULT "):
                return json.loads(line[7:]), seconds
        last = (run.stderr.strip().splitlines() or ["no word"])[-1]
        return None, f"ends after {seconds:.0f} s with “{last}”"


def main(binary, pele):
    here = os.path.dirname(os.path.abspath(__file__))
    binary = os.path.abspath(binary)
    rows = []
    for surface in (MullerBrown(), Fourier()):
        known = all_points(surface)
        (minima, saddles), calls, seconds = ours(binary, surface)
        rows.append([surface.name, "landscape", compared(minima, known[0]), compared(saddles, known[1]), calls, f"{seconds:.1f}"])
        found, told = peer(PEER.format(
            here=here, coordinates="StandardCoordinates", step="StandardPerturbation",
            body=FUNCTION.format(surface=type(surface).__name__),
            hef="ts_conv_crit=1e-4, ts_steps=75, pushoff=1.0",
            neb="force_constant=10.0, image_density=10.0, max_images=50, neb_conv_crit=1e-2",
            steps=1000, temperature=100.0, cycles=8, remove=True))
        if found:
            rows.append([surface.name, "topsearch 0.0.3", compared(found[0], known[0]), compared(found[1], known[1]), found[3], f"{told:.1f}"])
        else:
            rows.append([surface.name, "topsearch 0.0.3", told, "", "", ""])
        print(rows[-2:], flush=True)
    # The published counts: J. P. K. Doye and D. J. Wales, J. Chem. Phys. 116, 3777 (2002).
    for atoms, minima, states in ((7, 4, 12), (8, 8, 42), (9, 21, 165), (10, 64, 635), (13, 1510, 28756)):
        of = [f" of {known}" for known in (minima, states)]
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "out")
            started = time.perf_counter()
            subprocess.run([binary, "surface", "lj", str(atoms), "--threads", "1", "-q", "--no-report", "-o", out], check=True)
            seconds = time.perf_counter() - started
            counts = json.load(open(os.path.join(out, "landscape.json")))
            rows.append([f"{atoms} Lennard-Jones atoms", "landscape", f"{counts['counts']['minima']}{of[0]}",
                         f"{counts['findings']['saddles']}{of[1]}", counts["counts"]["evaluations"], f"{seconds:.1f}"])
        print(rows[-1], flush=True)
        if pele:
            found, told = peer(PELE.format(atoms=atoms, hops=500), pele)
            counts = [f"{found[0]}{of[0]}", f"{found[1]}{of[1]}", "", f"{told:.1f}"] if found else [told, "", "", ""]
            rows.append([f"{atoms} Lennard-Jones atoms", "pele 0.1.2, until connected", *counts])
            print(rows[-1], flush=True)
    found, told = peer(PEER.format(
        here=here, coordinates="AtomicCoordinates", step="AtomicPerturbation", body=CLUSTER,
        hef="ts_conv_crit=1e-4, ts_steps=150, pushoff=1e-1, max_uphill_step_size=0.3, positive_eigenvalue_step=0.3",
        neb="force_constant=50.0, image_density=10.0, max_images=20, neb_conv_crit=1e-2",
        steps=150, temperature=1.0, cycles=4, remove=False))
    if found:
        rows.append(["7 Lennard-Jones atoms", "topsearch 0.0.3", f"{len(found[0])} stored, 4 exist", f"{len(found[1])} stored, 12 exist", "", f"{told:.1f}"])
    else:
        rows.append(["7 Lennard-Jones atoms", "topsearch 0.0.3", told, "", "", ""])
    print(rows[-1], flush=True)
    text = (
        "# Beside other programs\n\nOne thread each, one after the other, in one run of `analysis/peers/run.py`, with the settings of "
        "their own examples (topsearch) and by default (landscape). On the two functions both call the same Python code. pele "
        "hops 500 times and then joins minima until all are connected: it does not look for all saddles. topsearch’s clusters "
        "include points that are no minima. By default, landscape ends after 100,000 searches, which 13 atoms reach.\n\n| surface | program | minima | saddles | "
        "calls of the energy | seconds |\n|---|---|---|---|---|---|\n")
    text += "".join("| " + " | ".join(str(cell) for cell in row) + " |\n" for row in rows)
    with open(OUTPUT + ".new", "w") as file:
        file.write(text)
    os.replace(OUTPUT + ".new", OUTPUT)
    print(text)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve(sys.argv[2])
    elif len(sys.argv) in (2, 3):
        main(sys.argv[1], os.path.abspath(sys.argv[2]) if len(sys.argv) == 3 else None)
    else:
        sys.exit(__doc__)
