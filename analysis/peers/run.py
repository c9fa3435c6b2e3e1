"""landscape beside topsearch and pele on the same surfaces -> figures/peers.md

    python3 -m venv peers && peers/bin/pip install topsearch==0.0.3 "numpy<2" scipy
    python3 -m venv pele && pele/bin/pip install pele==0.1.2
    cargo build --release
    peers/bin/python analysis/peers/run.py target/release/landscape pele/bin/python FOLDER

Each program runs alone on one thread, with the settings of its own examples (topsearch, pele) or by default (landscape).
topsearch and pele are stopped after LIMIT seconds of a processor, and are then judged by what they have found so far. Results are kept
in FOLDER, and the same command goes on where it was stopped.

No program is believed. All points are handed to numpy, which moves them by Newton's method: a point counts if it is
stationary, has the right number of negative curvatures, and was not counted before. On the two functions the stationary points
are known from Newton's method on a grid; on seven atoms all energies are known (tests/reference/landscapes.json); on larger
clusters only the published counts are.
"""

import json
import math
import os
import resource
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../lennard_jones"))
import stationary  # noqa: E402

OUTPUT = "figures/peers.md"
# Seconds of a processor after which a peer is stopped.
LIMIT = 90
SAME = 1e-3
# Minima and saddles that are published: J. P. K. Doye and D. J. Wales, J. Chem. Phys. 116, 3777 (2002).
PUBLISHED = {7: (4, 12), 8: (8, 42), 9: (21, 165), 10: (64, 635), 11: (170, 2424), 12: (515, 8607), 13: (1510, 28756)}
HOPS = 500


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
    """All minima and all saddles in the bounds, by Newton's method from a grid."""
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


def descended(surface, x):
    """The end of a descent in small steps."""
    for _ in range(200000):
        slope = surface.value_and_slope(x)[1]
        steepness = np.linalg.norm(slope)
        if steepness < 1e-7:
            break
        x = x - slope * min(2e-4, 2e-3 / steepness)
    return x


def connections(surface, minima, saddles):
    """The two minima below each saddle, by descents on both sides."""
    ends = []
    for x, _, _ in saddles:
        mode = np.linalg.eigh(hessian(surface, x))[1][:, 0]
        below = [descended(surface, x + side * 1e-3 * mode) for side in (1, -1)]
        ends.append([int(np.argmin([np.linalg.norm(y - m[0]) for m in minima])) for y in below])
    return ends


def judged(surface, coordinates, known):
    """As `stationary.judged`, by the places of the known points."""
    number, false, twice = [], 0, 0
    for x in coordinates:
        near = [k for k, point in enumerate(known) if np.linalg.norm(np.array(x) - point[0]) < 10 * SAME]
        twice += bool(near) and near[0] in number
        number.append(near[0] if near else None)
        false += not near
    return {"kept": [{"energy": known[k][1]} for k in sorted({k for k in number if k is not None})],
            "energies": [None if k is None else known[k][1] for k in number], "false": false, "twice": twice}


def findings(surface, atoms, known, found):
    """What a program has found, as numpy sees it."""
    told = {}
    for index, name in enumerate(("minima", "saddles")):
        if atoms:
            result = stationary.judged(found[name], index)
            energies = [None if k is None else result["kept"][k]["energy"] for k in result["number"]]
        else:
            result = judged(surface, found[name], known[index])
            energies = result["energies"]
        told[name] = {"right": sorted(point["energy"] for point in result["kept"]), "false": result["false"],
                      "twice": result["twice"], "energies": energies}
    told["ends"] = found["ends"]
    told["calls"] = found["calls"]
    return told


def way(told, lowest):
    """The highest point of the lowest way between two minima (their energies) over right points only, as a text."""
    minima = told["minima"]["energies"]
    place = [[k for k, e in enumerate(minima) if e is not None and abs(e - energy) < 1e-6] for energy in lowest]
    if not all(place):
        return "one of the two is not found"
    # Copies of a minimum are one.
    first = {}
    one = [first.setdefault(round(e, 6), k) if e is not None else k for k, e in enumerate(minima)]
    saddles = [(e, one[a], one[b]) for e, (a, b) in zip(told["saddles"]["energies"], told["ends"]) if e is not None]
    height = stationary.highest_on_the_way(len(minima), saddles, one[place[0][0]], one[place[1][0]])
    return "not joined" if height is None else f"{height:.6f}"


def timed(arguments, **settings):
    """Runs a program: its output and the seconds of processors, its children included."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run(arguments, capture_output=True, text=True, check=False, **settings)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    busy = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return run, busy


def ours(binary, surface, atoms):
    """The surface searched by landscape; a function is a program of its own."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out")
        if atoms:
            what = ["lj", str(atoms)]
        else:
            region = ",".join(f"{low}:{high}" for low, high in surface.bounds)
            command = f"{sys.executable} {os.path.abspath(__file__)} --serve {type(surface).__name__}"
            what = ["--command", command, f"--region={region}", "--protocol", "binary"]
        run, busy = timed([binary, "surface", *what, "--threads", "1", "-q", "--no-report",
                                  "-o", out], cwd=folder)
        if run.returncode:
            return None, f"ends with “{run.stderr.strip()}”", busy
        manifest = json.load(open(os.path.join(out, "landscape.json")))
        minima, saddles, ends = stationary.read(out, 3 * atoms if atoms else 2)
        found = {"minima": minima.tolist(), "saddles": saddles.tolist(), "ends": ends, "calls": manifest["counts"]["evaluations"]}
        searches = manifest["findings"]["coverage"]["searches"]
        # Another doubt may hide this one in the coverage.
        stopped = searches >= manifest["settings"]["max_searches"]
        return found, f"stopped after {searches} searches" if stopped else "by itself", busy


def serve(name):
    surface = {"MullerBrown": MullerBrown, "Fourier": Fourier}[name]()
    while True:
        data = sys.stdin.buffer.read(16)
        if len(data) < 16:
            return
        value, slope = surface.value_and_slope(np.frombuffer(data))
        sys.stdout.buffer.write(np.array([value, *slope]).tobytes())
        sys.stdout.buffer.flush()


GUARD = r'''
import json, signal, sys, time, numpy as np
class Stopped(BaseException):
    pass
def stop(*_):
    raise Stopped
signal.signal(signal.SIGPROF, stop)
# Again and again, because some code catches everything.
signal.setitimer(signal.ITIMER_PROF, {limit}, 5)
end = "by itself"
'''

TOPSEARCH = GUARD + r'''
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
try:
    explorer.get_minima(coords, {steps}, 1e-5, {temperature}, test_valid=True)
    explorer.get_transition_states('ClosestEnumeration', {cycles}, remove_bounds_minima={remove})
except Stopped:
    end = "stopped after {limit} s"
signal.setitimer(signal.ITIMER_PROF, 0)
edges = [(int(a), int(b)) for a, b in ktn.G.edges if max(a, b) < ktn.n_minima]
found = dict(minima=[list(map(float, ktn.get_minimum_coords(i))) for i in range(ktn.n_minima)],
             saddles=[list(map(float, ktn.get_ts_coords(*edge))) for edge in edges], ends=edges, calls=calls)
print("RESULT " + json.dumps([found, end]))
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
class Counted(LennardJones):
    def function(self, x):
        global calls
        calls += 1
        return super().function(x)
    def gradient(self, x):
        global calls
        calls += 1
        return super().gradient(x)
    def function_gradient(self, x):
        global calls
        calls += 1
        return super().function_gradient(x)
potential = Counted()
corners = [[0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, 0], [0, 0, 3], [0, 3, 3], [3, 3, 3], [3, 0, 3]]
position = np.array(corners + [[x + 6, y, z] for x, y, z in corners], float)[:{atoms}]
coords = AtomicCoordinates(atom_labels=['C'] * {atoms}, position=position.flatten(), bond_cutoff=1.5)
comparer = MolecularSimilarity(distance_criterion=0.1, energy_criterion=5e-2, weighted=False)
step_taking = AtomicPerturbation(max_displacement=0.5, max_atoms=3)
'''

PELE = GUARD + r'''
np.random.seed(0)
calls = None
{system}
from pele.landscape import ConnectManager
database = system.create_database()
try:
    system.get_basinhopping(database=database, outstream=None, {hopping}).run({hops})
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
except Stopped:
    end = "stopped after {limit} s"
signal.setitimer(signal.ITIMER_PROF, 0)
minima, states = list(database.minima()), list(database.transition_states())
place = dict((m.id(), k) for k, m in enumerate(minima))
found = dict(minima=[list(map(float, m.coords)) for m in minima], saddles=[list(map(float, t.coords)) for t in states],
             ends=[[place[t.minimum1.id()], place[t.minimum2.id()]] for t in states], calls=calls)
print("RESULT " + json.dumps([found, end]))
'''

PELE_CLUSTER = '''
from pele.systems import LJCluster
system = LJCluster({atoms})
'''

PELE_FUNCTION = '''
sys.path.insert(0, {here!r})
import run
from pele.potentials import BasePotential
from pele.systems import BaseSystem
surface = run.{surface}()
calls = 0
class Wrapped(BasePotential):
    def getEnergy(self, x):
        return self.getEnergyGradient(x)[0]
    def getEnergyGradient(self, x):
        global calls
        calls += 1
        return surface.value_and_slope(np.array(x))
class System(BaseSystem):
    def get_potential(self):
        return Wrapped()
    def get_random_configuration(self):
        return np.array([np.random.uniform(low, high) for low, high in surface.bounds])
    def get_mindist(self):
        return lambda a, b: (np.linalg.norm(a - b), a, b)
    def get_compare_exact(self):
        return lambda a, b: np.linalg.norm(a - b) < 1e-2
    def get_compare_minima(self):
        return lambda a, b: np.linalg.norm(a.coords - b.coords) < 1e-2
    def get_orthogonalize_to_zero_eigenvectors(self):
        return None
system = System()
from pele.takestep import RandomDisplacement
'''

# With its own temperature of 1, pele would not leave the first minimum of these functions: this is topsearch's.
PELE_HOPPING = "temperature=100.0, insert_rejected=True, takestep=RandomDisplacement(stepsize=1.0)"


def peer(script, python=sys.executable):
    """Runs a peer in a process of its own: what it found, how it ended, and its seconds."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "peer.py")
        open(path, "w").write(script)
        try:
            run, busy = timed([python, path], cwd=folder, timeout=20 * LIMIT,
                                 env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"})
        except subprocess.TimeoutExpired:
            return None, "killed", None
        for line in run.stdout.splitlines():
            if line.startswith("RESULT "):
                return *json.loads(line[7:]), busy
        last = (run.stderr.strip().splitlines() or ["no word"])[-1]
        return None, f"ends with “{last}”", busy


def reference(surface, atoms, runs):
    """Counts of minima and saddles, the energies of the two lowest minima, and the height of the lowest way between them."""
    if atoms == 7:
        path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tests/reference/landscapes.json")
        known = json.load(open(path))["LJ7"]
        return (len(known["minima"]), len(known["ts"])), known["minima"][:2], known["minimax"][0][1], [
            known["minima"], [state["energy"] for state in known["ts"]]]
    if atoms:
        # The two lowest minima that any of the programs has found.
        lowest = []
        for energy in sorted(e for told in runs for e in told["minima"]["right"]):
            if not lowest or energy - lowest[-1] > 1e-6:
                lowest.append(energy)
        return PUBLISHED[atoms], lowest[:2], None, None
    minima, saddles = all_points(surface)
    ends = connections(surface, minima, saddles)
    height = stationary.highest_on_the_way(len(minima), [(s[1], *e) for s, e in zip(saddles, ends)], 0, 1)
    return (len(minima), len(saddles)), [m[1] for m in minima[:2]], height, [[m[1] for m in minima], [s[1] for s in saddles]]


def main(binary, pele, folder):
    here = os.path.dirname(os.path.abspath(__file__))
    binary, pele = os.path.abspath(binary), os.path.abspath(pele)
    os.makedirs(folder, exist_ok=True)
    surfaces = [(surface.name, surface, None) for surface in (MullerBrown(), Fourier())]
    surfaces += [(f"{atoms} Lennard-Jones atoms", None, atoms) for atoms in PUBLISHED]
    table = []
    for name, surface, atoms in surfaces:
        if atoms:
            settings = dict(
                coordinates="AtomicCoordinates", step="AtomicPerturbation", body=CLUSTER.format(atoms=atoms), steps=150,
                hef="ts_conv_crit=1e-4, ts_steps=150, pushoff=1e-1, max_uphill_step_size=0.3, positive_eigenvalue_step=0.3",
                neb="force_constant=50.0, image_density=10.0, max_images=20, neb_conv_crit=1e-2",
                temperature=1.0, cycles=4, remove=False)
            system = PELE_CLUSTER.format(atoms=atoms)
        else:
            settings = dict(
                coordinates="StandardCoordinates", step="StandardPerturbation",
                body=FUNCTION.format(surface=type(surface).__name__), steps=1000,
                hef="ts_conv_crit=1e-4, ts_steps=75, pushoff=1.0",
                neb="force_constant=10.0, image_density=10.0, max_images=50, neb_conv_crit=1e-2",
                temperature=100.0, cycles=8, remove=True)
            system = PELE_FUNCTION.format(here=here, surface=type(surface).__name__)
        programs = {
            "landscape": lambda s=surface, a=atoms: ours(binary, s, a),
            "pele 0.1.2, until connected": lambda text=system, hopping="" if atoms else PELE_HOPPING: peer(
                PELE.format(system=text, hops=HOPS, hopping=hopping, limit=LIMIT), pele),
            "topsearch 0.0.3": lambda s=settings: peer(TOPSEARCH.format(here=here, limit=LIMIT, **s)),
        }
        known = all_points(surface) if surface else None
        results = {}
        for program, run in programs.items():
            path = os.path.join(folder, f"{name}, {program}.json")
            if not os.path.exists(path):
                found, end, busy = run()
                told = findings(surface, atoms, known, found) if found else None
                with open(path + ".new", "w") as file:
                    json.dump([told, end, busy], file)
                os.replace(path + ".new", path)
                print(name, program, end, busy, flush=True)
            results[program] = json.load(open(path))
        runs = [told for told, _, _ in results.values() if told]
        counts, lowest, height, energies = reference(surface, atoms, runs)
        source = "computed on a grid" if surface else "published"
        table.append([name, source, *counts, "", f"{height:.6f}" if height is not None else "not known", "", "", ""])
        for program, (told, end, busy) in results.items():
            seconds = "" if busy is None else f"{busy:.1f}"
            if not told:
                table.append([name, program, "", "", "", "", "", seconds, end])
                continue
            right = [told[kind]["right"] for kind in ("minima", "saddles")]
            if energies:
                # Where all energies are known, a point must have one of them.
                right = [[e for e in mine if any(abs(e - k) < 1e-6 for k in all_)] for mine, all_ in zip(right, energies)]
            wrong = sum(told[kind]["false"] + told[kind]["twice"] for kind in ("minima", "saddles"))
            table.append([name, program, *(f"{len(mine)} of {count}" for mine, count in zip(right, counts)), wrong,
                          way(told, lowest), told["calls"] or "", seconds, end])
    text = (
        "# Beside other programs\n\nMade by `analysis/peers/run.py`. Each program ran alone on one thread while other work ran on "
        "the machine; seconds are those of processors. landscape has its default settings. The others have the "
        f"settings of their own examples and are stopped after {LIMIT} s. pele hops "
        f"{HOPS} times and then joins minima until all are connected: it does not look for all saddles. topsearch keeps one saddle "
        "for each pair of minima. On the two functions all programs call the same Python code, and pele hops with the temperature "
        "and the steps of topsearch, because with its own temperature it does not leave the first minimum. Calls of pele on "
        "clusters are not counted.\n\n"
        "A minimum or saddle counts if numpy confirms it: it is stationary, has the right number of negative curvatures, and "
        "was not counted before. All other points that a program keeps are in the column of wrong points. On the two functions "
        "and on 7 atoms each energy also is one of the reference to 10⁻⁶. For larger clusters only counts are published (J. P. "
        "K. Doye and D. J. Wales, J. Chem. Phys. 116, 3777 (2002)). The last "
        "column but three is the energy of the highest point of the lowest way between the two lowest minima, over right saddles "
        "that the program has found. A higher value than another program’s is a way that is not the lowest.\n\n"
        "| surface | program | minima | saddles | wrong or double points | highest point between the two lowest minima | calls of "
        "the energy | seconds | end |\n|---|---|---|---|---|---|---|---|---|\n")
    text += "".join("| " + " | ".join(str(cell) for cell in row) + " |\n" for row in table)
    with open(OUTPUT + ".new", "w") as file:
        file.write(text)
    os.replace(OUTPUT + ".new", OUTPUT)
    print(text)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve(sys.argv[2])
    elif len(sys.argv) == 4:
        main(*sys.argv[1:])
    else:
        sys.exit(__doc__)
