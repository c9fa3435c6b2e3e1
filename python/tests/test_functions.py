"""Energies given as Python functions: published numbers, errors, threads, interruptions, leaks."""

import os
import signal
import sys
import threading
import time
import traceback

import numpy as np
import pytest

import landscape as ls


def lennard_jones(x):
    r = x.reshape(-1, 3)
    d = r[:, None] - r[None]
    s = (d**2).sum(-1) + np.eye(len(r))
    i6 = s**-3
    np.fill_diagonal(i6, 0)
    return 2 * (i6**2 - i6).sum(), ((-24 * (2 * i6**2 - i6) / s)[..., None] * d).sum(1).ravel()


def camel(p):
    x, y = p
    slope = np.array([8 * x - 8.4 * x**3 + 2 * x**5 + y, x - 8 * y + 16 * y**3])
    return (4 - 2.1 * x * x + x**4 / 3) * x * x + x * y + (4 * y * y - 4) * y * y, slope


CAMEL_BOX = ([-2.0, -1.0], [2.0, 1.0])


@pytest.fixture(scope="module")
def humps():
    return ls.explore(camel, box=CAMEL_BOX, seed=0)


def test_six_hump_camel_has_its_published_minima(humps):
    assert humps.minima.rows == 6
    assert humps.minima.energy[:2] == pytest.approx([-1.031628, -1.031628], abs=1e-5)
    assert humps.minima.coordinates[0] == pytest.approx(humps.minima.coordinates[1] * -1, abs=1e-5)
    assert humps.coverage.sure > 0.8 and humps.coverage.minima == 6
    height = humps.tree.merge_height(0, 1)
    assert height == humps.tree.heights()[0, 1] and height > humps.minima.energy[1]
    path = humps.path(0, 1)
    assert path.height == pytest.approx(height, abs=1e-6)
    assert path.minima[0] == 0 and path.minima[-1] == 1 and (np.diff(path.length) > 0).all()


def test_lennard_jones_of_seven_atoms():
    found = ls.explore(lennard_jones, ls.Atoms(7), box=(-1.2, 1.2), seed=0, patience=4)
    assert found.minima.energy == pytest.approx([-16.505384, -15.935043, -15.593211, -15.533060], abs=1e-5)
    assert found.tree.merge_height(0, 2) == pytest.approx(-15.3199, abs=1e-3)


def test_equal_seeds_give_equal_bytes(tmp_path):
    one, two = (ls.explore(camel, box=CAMEL_BOX, seed=3, out=tmp_path / name) for name in ("a.landscape", "b.landscape"))
    for name in ("minima.parquet", "stationary.parquet", "landscape.json", "tree.nwk", "min.data"):
        assert (one.folder / name).read_bytes() == (two.folder / name).read_bytes(), name


def test_batch_and_hessian_find_the_same_minima(humps):
    def many(points):
        pairs = [camel(p) for p in points]
        return np.array([e for e, _ in pairs]), np.array([g for _, g in pairs])

    def bent(p):
        x, y = p
        return [[8 - 25.2 * x**2 + 10 * x**4, 1], [1, -8 + 48 * y**2]]

    for found in (ls.explore(many, box=CAMEL_BOX, batch=True), ls.explore(camel, box=CAMEL_BOX, hessian=bent)):
        assert found.minima.energy == pytest.approx(humps.minima.energy, abs=1e-8)


def test_map_joins_given_minima():
    def waves(x):
        return np.cos(3 * x).sum(), -3 * np.sin(3 * x)

    starts = [[1.0], [3.0], [-1.0]]
    found = ls.map(waves, starts, ls.Torus(1), name="wells")
    chains = ls.map(waves, starts, ls.Torus(1), name="wells", search="adelm")
    assert chains.minima.rows == 3 and chains.tree.merge_height(0, 1) > 0.99
    assert found.minima.rows == 3 and found.tree.merge_height(0, 1) == pytest.approx(1.0, abs=1e-3)
    assert found.newick().strip().endswith(";")


def test_copies_by_declared_symmetries_are_one_point():
    def wells(x):
        return float(((x**2 - 1) ** 2).sum()), 4 * x * (x**2 - 1)

    given = {"box": (-2.0, 2.0), "name": "wells"}
    one = ls.explore(wells, ls.Euclidean(2, symmetries=[[2, 1], [-1, 2]]), **given)
    assert ls.explore(wells, ls.Euclidean(2), **given).minima.rows == 4 and one.minima.rows == 1
    for symmetries, words in [
        ([[2, 1, 3]], "symmetries: symmetry 1 has 3 numbers"),
        ([[2, 1.5]], "lists of whole numbers"),
        ([], "the list is empty"),
    ]:
        with pytest.raises(ls.InputError, match=words):
            ls.explore(wells, ls.Euclidean(2, symmetries=symmetries), **given)
    tilted = lambda x: (wells(x)[0] + 0.3 * x[0], wells(x)[1] + np.array([0.3, 0.0]))  # noqa: E731
    with pytest.raises(ls.InputError, match="symmetry 1 changes the energy"):
        ls.explore(tilted, ls.Euclidean(2, symmetries=[[-1, 2]]), **given)


def test_descents():
    ends = ls.quench(lambda x: (float((x**2).sum()), 2 * x), [[3.0, -2.0]])
    assert ends.converged.all() and abs(ends.x).max() < 1e-4


def test_a_minimum_may_lie_on_a_face_of_the_box():
    def falls(x):
        return -x[0], np.array([-1.0])

    slope = ls.explore(falls, ls.Box(), box=(0.0, 2.0))
    assert slope.minima.coordinates[0] == pytest.approx([2.0])
    again = ls.explore(falls, ls.Box(), box=(0.0, 2.0), known=[[2.0]])
    assert again.minima.coordinates[0] == pytest.approx([2.0])
    with pytest.raises(ls.InputError, match="known: row 1 is outside the box"):
        ls.explore(falls, ls.Box(), box=(0.0, 2.0), known=[[2.0], [5.0]])


def test_a_wrong_gradient_is_told_with_numbers():
    def wrong(x):
        return float(x[0] ** 2 + 0.1 * x[0] * x[1] + x[1] ** 2), np.array([2 * x[0] + 0.1 * x[1], 2 * x[1]])

    with pytest.raises(ls.GradientError, match="component 1") as told:
        ls.explore(wrong, box=([-1, -1], [1, 1]))
    error = told.value
    assert error.component == 1 and len(error.x) == 2
    assert error.measured - error.given == pytest.approx(0.1 * error.x[0], abs=1e-4)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (lambda x: (float("nan"), x), "energy is NaN"),
        (lambda x: (0.0, x * np.nan), "component 0 of the gradient is NaN"),
        (lambda x: (0.0, [1.0]), "must have 2 numbers, but has 1"),
        (lambda x: 3.0, "two values, energy and gradient"),
        (lambda x: ("high", x), "must be a number, but is str"),
        (lambda x: (float("-inf"), x), "energy is -inf"),
    ],
)
def test_what_is_no_energy_is_told_with_its_point(answer, words):
    with pytest.raises(ls.EnergyError, match=words) as told:
        ls.explore(answer, box=([-1, -1], [1, 1]))
    assert len(told.value.x) == 2 and "at x = [" in str(told.value)


def test_an_exception_keeps_its_traceback():
    calls = 0

    def breaks(x):
        nonlocal calls
        calls += 1
        if calls > 200:
            raise ZeroDivisionError("on purpose")
        return camel(x)

    with pytest.raises(ZeroDivisionError, match="on purpose") as told:
        ls.explore(breaks, box=CAMEL_BOX)
    assert any(frame.name == "breaks" for frame in traceback.extract_tb(told.value.__traceback__))
    assert calls < 300, "the function is not asked again after its error"


def test_interruption_ends_a_search_within_a_second():
    def slow(x):
        time.sleep(0.002)
        return lennard_jones(x)

    # A shell that runs the tests in the background lets them ignore the signal.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        ls.explore(slow, ls.Atoms(13), box=(-1.8, 1.8))
    assert time.monotonic() - started < 2.0


def test_other_threads_run_on_and_nothing_deadlocks():
    results, ticks = [], 0

    def search():
        results.append(ls.explore(camel, box=CAMEL_BOX, seed=1).minima.rows)

    threads = [threading.Thread(target=search) for _ in range(3)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        ticks += 1
        time.sleep(0.005)
        assert ticks < 20000
    assert results == [6, 6, 6] and ticks > 5


def busiest(**how):
    """The largest number of calls at the same time, and the energies."""
    lock, running, most = threading.Lock(), 0, 0

    def sleepy(x):
        nonlocal running, most
        with lock:
            running += 1
            most = max(most, running)
        time.sleep(0.002)
        with lock:
            running -= 1
        return camel(x)

    energies, gradients = ls.evaluate(sleepy, np.linspace(CAMEL_BOX[0], CAMEL_BOX[1], 200), box=CAMEL_BOX, **how)
    return most, energies, gradients


def test_calls_share_the_threads_that_python_allows():
    locked = getattr(sys, "_is_gil_enabled", lambda: True)()
    usual, energies, gradients = busiest()
    assert usual == 1 if locked else 1 <= usual <= os.cpu_count()
    for threads in (1, 3):
        most, again, slopes = busiest(threads=threads)
        assert (most > 1) == (threads > 1) and most <= threads
        assert (again == energies).all() and (slopes == gradients).all()
    with pytest.raises(ls.InputError, match="threads 0: a whole number from 1 to 1024"):
        busiest(threads=0)


def test_the_number_of_threads_changes_no_byte(tmp_path):
    one, four = (
        ls.explore(camel, box=CAMEL_BOX, seed=3, threads=threads, out=tmp_path / f"{threads}.landscape").folder
        for threads in (1, 4)
    )
    names = sorted(path.name for path in one.iterdir() if path.name != "timings.json")
    assert "minima.parquet" in names and len(names) > 5
    for name in names:
        assert (one / name).read_bytes() == (four / name).read_bytes(), name


def test_an_exception_in_one_of_many_threads_ends_the_search():
    calls = 0

    def sometimes(x):
        nonlocal calls
        calls += 1
        if calls > 400:
            raise ZeroDivisionError("call 400")
        return camel(x)

    with pytest.raises(ZeroDivisionError, match="call 400"):
        ls.explore(sometimes, box=CAMEL_BOX, threads=4)


def test_a_million_calls_leak_nothing():
    psutil = pytest.importorskip("psutil")
    answer = (0.0, np.zeros(2))
    points = np.zeros((100_000, 2))
    process = psutil.Process()
    ls.evaluate(lambda x: answer, points, box=(-1, 1))
    before = process.memory_info().rss
    for _ in range(10):
        ls.evaluate(lambda x: answer, points, box=(-1, 1))
    assert process.memory_info().rss - before < 30e6


def test_a_call_costs_little():
    answer = (0.0, np.zeros(2))
    points = np.zeros((100_000, 2))

    def function(x):
        return answer

    def per_call(work):
        times = []
        for _ in range(3):
            started = time.perf_counter()
            work()
            times.append((time.perf_counter() - started) / len(points))
        return min(times)

    x = points[0]
    own = per_call(lambda: [function(x) for _ in range(len(points))])
    ours = per_call(lambda: ls.evaluate(function, points, box=(-1, 1), threads=1))
    print(f"overhead of a call: {1e6 * (ours - own):.2f} µs")
    assert ours - own < 3e-6


def test_wrong_arguments_are_told():
    with pytest.raises(ls.InputError, match="box=\\(low, high\\) is needed"):
        ls.explore(camel)
    with pytest.raises(ls.InputError, match="low < high"):
        ls.explore(camel, box=([1, 1], [-1, -1]))
    with pytest.raises(ls.InputError, match="minimum 9 does not exist"):
        ls.explore("muller-brown").path(0, 9)
    with pytest.raises(ls.NothingFoundError):
        ls.map(lambda x: (float((x**2).sum()), 2 * x), [[1.0], [0.5]])
    with pytest.raises(FileNotFoundError):
        ls.load("there-is-none.landscape")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"space": ls.Euclidean}, "space: .* not the class Euclidean"),
        ({"space": "torus"}, "space: .* not 'torus'"),
        ({"seed": -1}, "seed -1: a whole number from 0"),
        ({"seed": 0.5}, "seed 0.5: a whole number"),
        ({"lowest": 0}, "lowest 0: .* from 2 to 1000000"),
        ({"searches": 0}, "searches 0: .* from 1"),
        ({"patience": 0}, "patience 0: .* from 1"),
        ({"threads": 1025}, "threads 1025: .* to 1024"),
        ({"family_barrier": -0.1}, "family_barrier -0.1: a finite number, 0 or more"),
        ({"family_barrier": float("nan")}, "family_barrier nan"),
        ({"budget_s": "long"}, "budget_s 'long': a number"),
        ({"hessian": 3}, "hessian: a function of a point is needed, not int"),
    ],
)
def test_a_wrong_argument_of_a_search_is_told(given, words):
    with pytest.raises(ls.InputError, match=words):
        ls.explore(camel, box=CAMEL_BOX, **given)


@pytest.mark.parametrize(
    "given", [{"space": ls.Torus(2)}, {"box": (0, 1)}, {"known": [[0.0]]}, {"hessian": camel}, {"batch": True}, {"name": "x"}]
)
def test_a_model_refuses_what_only_functions_take(given):
    with pytest.raises(ls.InputError, match=f"{next(iter(given))}: the model 'lj 7' takes none"):
        ls.explore("lj 7", **given)


def test_wrong_points_and_spaces_are_told():
    def bowl(x):
        return float((x**2).sum()), 2 * x

    for call, words in [
        (lambda: ls.Atoms(-1), "n of Atoms -1: a whole number from 1"),
        (lambda: ls.Torus(1.5), "n of Torus 1.5: a whole number"),
        (lambda: ls.map(bowl, [[1.0], [2.0, 3.0]]), "minima: an array of numbers is needed"),
        (lambda: ls.map(bowl, [[1.0], [2.0]], search="chains"), 'search: "passes" or "adelm"'),
        (lambda: ls.evaluate(bowl, [1.0, 2.0]), r"points has the shape \(2,\), but \(k, n\)"),
        (lambda: ls.quench(bowl, [[1.0]], gradient_tolerance=float("nan")), "gradient_tolerance nan"),
        (lambda: ls.quench(bowl, [[1.0]], gradient_tolerance=-1e-3), "gradient_tolerance -0.001"),
    ]:
        with pytest.raises(ls.InputError, match=words):
            call()


def test_numbers_of_numpy_are_numbers():
    one = ls.explore("muller-brown", seed=np.int64(0), family_barrier=np.float32(0.5))
    assert one.rates([np.int64(1)], 0, np.float32(20))["at"] == one.rates([1], ["m0"], 20.0)["at"]
    assert one.tree.merge_height(np.int64(0), np.int32(1)) == one.tree.merge_height(0, 1)
    many = ls.explore(camel, ls.Euclidean(np.int64(2)), box=CAMEL_BOX, threads=np.int8(1), searches=np.uint16(40))
    assert many.minima.rows > 1


def test_a_wrong_gradient_is_told_by_a_descent():
    def wrong(x):
        return float((x**2).sum()), 3 * x

    with pytest.raises(ls.GradientError):
        ls.quench(wrong, [[1.0, 2.0]])
    assert len(ls.quench(wrong, [[1.0, 2.0]], check_gradient=False).x) == 1


def test_known_points_are_where_the_search_begins():
    asked = set()

    def wells(x):
        asked.add(tuple(x))
        return np.cos(4 * x).sum(), -4 * np.sin(4 * x)

    corners = np.pi / 4 * np.array([1, 3, -1, -3])
    known = np.array(np.meshgrid(corners, corners, corners)).reshape(3, -1).T
    alone = ls.explore(wells, ls.Torus(3), searches=64)
    assert alone.minima.rows < 64, "a search of each minimum cannot find all of them"
    asked.clear()
    begun = ls.explore(wells, ls.Torus(3), searches=64, known=known)
    assert begun.minima.rows == 64 and all(tuple(point) in asked for point in known)
    with pytest.raises(ls.InputError, match="known"):
        ls.explore(camel, box=CAMEL_BOX, known=[[0.0, 0.0, 0.0]])


def test_the_lowest_minima_are_sought_from_below():
    found = ls.explore(lennard_jones, ls.Atoms(8), box=(-1.3, 1.3), search="lowest", lowest=2, searches=300)
    # D. J. Wales and J. P. K. Doye, J. Phys. Chem. A 101, 5111 (1997).
    assert found.minima.energy[0] == pytest.approx(-19.821489, abs=1e-5)
    assert found.manifest["findings"]["lowest"]["sought"] == 2
    assert "lowest" not in ls.explore(camel, box=CAMEL_BOX, search="all").manifest["findings"]
    with pytest.raises(ls.InputError, match="searches are"):
        ls.explore(camel, box=CAMEL_BOX, search="highest")


def test_a_budget_ends_a_search_with_what_it_found():
    found = ls.explore(lennard_jones, ls.Atoms(7), box=(-1.2, 1.2), search="all", patience=1000, budget_s=0.5)
    assert any("stopped by --budget" in warning for warning in found.manifest["warnings"])
    assert found.minima.rows >= 1 and 1 <= found.coverage.searches < 500
    with pytest.raises(ls.InputError, match="budget_s"):
        ls.explore(camel, box=CAMEL_BOX, budget_s=-1.0)


def test_rotations():
    """Four orientations are equally good: by half turns about the axes of the body."""
    turns = np.array([[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]], [[0, -1, 0], [1, 0, 0], [0, 0, 0]]])
    weights = np.array([3.0, 2.0, 1.0])

    def energy(q):
        w, x, y, z = q
        r = np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ])
        slopes = np.einsum("jii->ij", r @ turns)
        return -(weights * np.diag(r) ** 2).sum(), -2 * (weights * np.diag(r)) @ slopes

    asked = []

    def watched(q):
        asked.append(q.copy())
        return energy(q)

    found = ls.explore(watched, ls.Rotations())
    assert np.linalg.norm(asked, axis=1) == pytest.approx(np.ones(len(asked)), abs=1e-9), "unit quaternions only"
    assert found.minima.energy == pytest.approx([-6.0] * 4, abs=1e-8)
    quaternions = found.minima.coordinates
    assert abs(quaternions).max(axis=1) == pytest.approx(np.ones(4), abs=1e-5)
    assert sorted(abs(quaternions).argmax(axis=1)) == [0, 1, 2, 3]
    # The cheapest quarter turn is that about the axis with the two least weights: E(φ) = −3 − (2 + 1) cos² φ.
    assert found.tree.heights()[0, 1:].min() == pytest.approx(-3.0, abs=1e-6)
    path = found.path(0, 1)
    assert np.linalg.norm(path.coordinates, axis=1) == pytest.approx(np.ones(len(path.energy)), abs=1e-9)
    ends = ls.quench(energy, [[0.9, 0.1, 0.0, 0.0], [0.5, 0.5, 0.5, 0.4]], ls.Rotations())
    assert ends.converged.all() and ends.energy == pytest.approx([-6.0] * 2, abs=1e-6)
    with pytest.raises(ls.InputError, match="row 1 is not a quaternion"):
        ls.quench(energy, [[1.0, 0.0, 0.0, 0.0], [0.0] * 4], ls.Rotations())


def test_periodic_numbers_wrap_at_their_own_side():
    sides = np.array([2.0, 3.0])

    def energy(p):
        u = 2 * np.pi * np.array([2, 1]) / sides
        return -np.cos(u * p).sum(), u * np.sin(u * p)

    found = ls.explore(energy, ls.Periodic(), box=([0.0, 0.0], sides))
    assert found.minima.energy == pytest.approx([-2.0, -2.0], abs=1e-8)
    wrapped = np.sort(np.round(found.minima.coordinates / sides % 1.0, 5) % 1.0, axis=0)
    assert wrapped == pytest.approx(np.array([[0.0, 0.0], [0.5, 0.0]]), abs=1e-4)
    # Two ways lead from one to the other, and one over the side of the cell back to each.
    joined = found.saddles.where(found.saddles.a != found.saddles.b)
    assert joined.rows == 2 and joined.energy == pytest.approx([0.0, 0.0], abs=1e-8)
    assert found.tree.merge_height(0, 1) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("aside", [True, False])
def test_a_panic_is_an_exception(aside):
    with pytest.raises(ls.InternalError, match="please report it: on purpose"):
        ls._native.panic("on purpose", aside)
    assert ls.explore("muller-brown").minima.rows == 3, "the interpreter and the threads go on"


def calculator():
    """The energy of :func:`lennard_jones` as an ASE calculator."""
    from ase.calculators.calculator import Calculator, all_changes

    class Pairs(Calculator):
        implemented_properties = ["energy", "forces"]

        def calculate(self, atoms=None, properties=("energy",), system_changes=all_changes):
            super().calculate(atoms, properties, system_changes)
            energy, gradient = lennard_jones(self.atoms.positions.ravel())
            self.results = {"energy": energy, "forces": -gradient.reshape(-1, 3)}

    return Pairs()


def test_ase_calculators():
    ase = pytest.importorskip("ase")
    from ase.calculators.lj import LennardJones

    atoms = ase.Atoms("Ar4", positions=np.random.default_rng(0).normal(size=(4, 3)))
    found = ls.explore(ls.from_ase(atoms, calculator()), box=(-1.0, 1.0), searches=64)
    assert found.minima.energy == pytest.approx([-6.0]) and found.saddles.rows == 1
    ends = ls.quench(ls.from_ase(atoms, LennardJones(rc=50.0)), found.minima.coordinates + 0.01)
    assert ends.converged.all() and ends.energy == pytest.approx([-6.0], abs=1e-6)
    atoms.pbc = True
    with pytest.raises(ls.InputError, match="periodic cell"):
        ls.from_ase(atoms, calculator())


def test_ase_atoms_of_several_elements():
    """An atom of another element in a bipyramid of five sits on the axis or around it; with equal forces, at equal energy."""
    ase = pytest.importorskip("ase")
    atoms = ase.Atoms("Ar3KrAr", positions=np.random.default_rng(0).normal(size=(5, 3)))
    mixed = ls.from_ase(atoms, calculator())
    assert mixed.space == ls.Atoms(5, ("Ar", "Ar", "Ar", "Kr", "Ar"))
    found = ls.explore(mixed, box=(-1.2, 1.2), searches=96)
    assert found.minima.energy == pytest.approx([-9.103852] * 2, abs=1e-5)
    positions = found.minima.coordinates.reshape(2, 5, 3)
    arms = np.linalg.norm(positions - positions.mean(axis=1, keepdims=True), axis=2)
    # The two atoms on the axis are the farthest from the middle.
    assert sorted((arms[:, [3]] < arms).sum(axis=1) <= 1) == [False, True]
    # Their point groups: C3v on the axis, C2v around it.
    orders = sorted(int(row.split()[2]) for row in (found.folder / "min.data").read_text().splitlines())
    assert orders == [4, 6]
    again = ls.load(found.folder)
    assert again.manifest["energy"]["coordinates"] == "atoms Ar Ar Ar Kr Ar"
    assert again.diff(found).matches.rows == 2 and again.path(0, 1) is not None
    assert "</html>" in found.report().read_text(encoding="utf-8")
    with pytest.raises(ls.InputError, match="5 of them, but 4"):
        ls.quench(mixed, np.zeros((1, 12)), ls.Atoms(4, mixed.space.elements))
