"""Where Python and the native module meet: the end of the interpreter, forks, odd poses, boxes, batches, Hessians."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import landscape as ls


def wells(p):
    x, y = p
    return (x * x - 1) ** 2 + y * y, np.array([4 * x * (x * x - 1), 2 * y])


def curvature(p):
    x, _ = p
    return np.array([[12 * x * x - 4, 0.0], [0.0, 2.0]])


WELLS_BOX = ([-2.0, -1.0], [2.0, 1.0])

ENDING = """
import threading, time
import landscape as ls

called = threading.Event()

def slow(x):
    called.set()
    time.sleep(1.0)
    return float((x**2).sum()), 2 * x

threading.Thread(target=lambda: ls.explore(slow, box=([-1, -1], [1, 1])), daemon=True).start()
print("called", called.wait(60))
"""


def test_a_running_function_does_not_end_the_process_by_force():
    done = subprocess.run([sys.executable, "-c", ENDING], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout) == (0, "called True\n"), done.stderr


FORKING = ENDING + """
import os, sys
child = os.fork()
if child == 0:
    sys.exit(0)
print("child", os.waitpid(child, 0)[1])
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_process_forked_during_a_search_ends():
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", FORKING], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and "child 0\n" in done.stdout, done.stderr


LOCKED = """
import threading
import numpy as np
import landscape as ls

ball, lock, points = ls.Object("ball"), threading.Lock(), np.full((4000, 3), 0.1)

def careful(x):
    with lock:
        ball.distance(points)
    return float((x**2).sum()), 2 * x

ls.evaluate(careful, np.zeros((200, 2)), box=(-1, 1), threads=4)
print("ended")
"""


def test_a_function_that_holds_a_lock_may_call_native_work():
    done = subprocess.run([sys.executable, "-c", LOCKED], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout) == (0, "ended\n"), done.stderr


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_process_is_told_to_spawn():
    ball = ls.Object("ball")
    ball.distance([[0.0, 0.0, 0.0]])
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe()

    def ask():
        try:
            theirs.send(str(ball.distance([[0.0, 0.0, 0.0]])))
        except RuntimeError as error:
            theirs.send(str(error))

    child = context.Process(target=ask)
    child.start()
    answered = ours.poll(30)
    told = ours.recv() if answered else "no answer"
    child.kill()
    assert "spawn" in told


def test_numbers_that_are_no_pose_are_refused():
    hand = ls.Hand("human")
    energy = ls.Energy(hand, ls.Object("ball"))
    pose = np.zeros((1, len(hand.rest_pose)))
    for ask in (energy, energy.evaluate):
        with pytest.raises(ls.InputError, match="row 0 has the quaternion .* length is 0"):
            ask(pose)
    pose[0, 3] = 1.0
    usual, _ = energy.evaluate(pose)
    pose[0, 3] = 1.0 + 1e-5
    assert energy.evaluate(pose)[0] == pytest.approx(usual, rel=1e-9), "a rounded quaternion is made one of unit length"
    pose[0, -1] = 1e200
    with pytest.raises(ls.InputError, match="too large"):
        energy(pose)


def test_points_far_away_are_refused():
    with pytest.raises(ls.InputError, match="row 1 is more than"):
        ls.Object("ball").distance([[0, 0, 0], [1e300, 0, 0]])
    with pytest.raises(ls.InputError, match="one atom"):
        ls.explore(lambda x: (0.0, 0 * x), ls.Atoms(1), box=(-1, 1))


def test_a_box_is_never_left():
    asked = []

    def downhill(x):
        asked.append(float(x[0]))
        return -float(x[0]), np.array([-1.0])

    ends = ls.quench(downhill, [[0.5], [1.5]], ls.Box(), box=([0.0], [2.0]))
    assert ends.x == pytest.approx(np.array([[2.0], [2.0]]), abs=1e-6)
    assert min(asked) >= 0 and max(asked) <= 2
    with pytest.raises(ls.InputError, match="row 0 is outside the box"):
        ls.evaluate(downhill, [[5.0]], ls.Box(), box=([0.0], [2.0]))
    with pytest.raises(ls.InputError, match="explore"):
        ls.map(downhill, [[0.5], [1.5]], ls.Box(), box=([0.0], [2.0]))


def test_many_points_are_asked_at_once():
    sizes = []

    def many(points):
        sizes.append(len(points))
        return (points**2).sum(1), 2 * points

    points = np.linspace(0, 1, 3000).reshape(1500, 2)
    energies, gradients = ls.evaluate(many, points, box=(-1, 2), batch=True)
    assert sum(sizes) == 1500 and max(sizes) > 500
    assert (energies == (points**2).sum(1)).all() and (gradients == 2 * points).all()


def test_arrays_of_a_wrong_shape_are_refused():
    with pytest.raises(ls.EnergyError, match=r"gradients of 3 points must be an array of the shape \(3, 2\)"):
        ls.evaluate(lambda points: ((points**2).sum(1), (2 * points).T), np.ones((3, 2)), box=(-1, 2), batch=True)


@pytest.mark.parametrize(
    ("hessian", "told"),
    [
        (lambda x: -curvature(x), "of the Hessian is"),
        (lambda x: curvature(x) * np.nan, "finite and symmetric"),
        (lambda x: curvature(x) + [[0, 1], [0, 0]], "finite and symmetric"),
        (lambda x: curvature(x)[0], "shape"),
    ],
)
def test_a_wrong_hessian_is_told(hessian, told):
    assert ls.explore(wells, box=WELLS_BOX, hessian=curvature).saddles.rows == 1
    with pytest.raises(ls.EnergyError, match=told):
        ls.explore(wells, box=WELLS_BOX, hessian=hessian)


def test_quench_checks_the_gradient():
    with pytest.raises(ls.GradientError):
        ls.quench(lambda x: (float((x**2).sum()), -2 * x), [[0.5, 0.5], [-0.3, 0.2]], box=(-1, 1))


def test_a_command_that_waits_for_its_turn_is_cancelled_too():
    usual = signal.signal(signal.SIGINT, signal.default_int_handler)
    first = threading.Thread(target=lambda: ls.explore("lj 13", search="all", budget_s=8))
    first.start()
    time.sleep(1.0)
    threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
    started = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            ls.explore("lj 20", budget_s=300)
    finally:
        signal.signal(signal.SIGINT, usual)
    assert time.monotonic() - started < 3 and first.is_alive(), "it waited for its turn"
    first.join()
    started = time.monotonic()
    assert ls.explore("muller-brown").minima.rows == 3
    assert time.monotonic() - started < 60, "the cancelled search did not run"


def test_what_was_repaired_is_noted(tmp_path):
    corners = [(0, 0, 0), (0.05, 0, 0), (0, 0.05, 0), (0, 0, 0.05)]
    turned = [(1, 2, 3), (1, 2, 4), (1, 3, 4), (2, 3, 4)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in turned]
    (tmp_path / "turned.obj").write_text("\n".join(lines) + "\n")
    assert any("turned" in note for note in ls.Object(str(tmp_path / "turned.obj")).notes)


def test_equal_atoms_in_a_fixed_frame_have_no_numbers():
    # Two atoms on two sites of a ring of length 2, which repel each other.
    def adatoms(x):
        along, rest = x[[0, 3]], x[[1, 2, 4, 5]]
        turn, apart = 2 * np.pi, np.pi * (x[0] - x[3])
        repulsion = 10 * np.exp(3 * (np.cos(apart) - 1))
        slope = np.zeros(6)
        slope[[0, 3]] = turn * np.sin(turn * along) + 0.1 * np.pi * np.sin(np.pi * along)
        slope[[0, 3]] += np.array([-1, 1]) * 3 * np.pi * repulsion * np.sin(apart)
        slope[[1, 2, 4, 5]] = 2 * rest
        energy = -np.cos(turn * along).sum() - 0.1 * np.cos(np.pi * along).sum() + (rest**2).sum() + repulsion
        return energy, slope

    box = ([0.0, -1.0, -1.0] * 2, [2.0, 1.0, 1.0] * 2)
    same, other = (
        ls.explore(adatoms, ls.FixedFrame(elements, periodic=True), box=box, seed=1, searches=24) for elements in [("Ar", "Ar"), ("Ar", "Kr")]
    )
    assert 0 < 2 * same.minima.rows == other.minima.rows
    assert same.minima.energy[0] == pytest.approx(other.minima.energy[0], abs=1e-9)


def test_maps_and_descents_take_functions_of_many_points_and_hessians():
    def many(points):
        x, y = points.T
        return (x * x - 1) ** 2 + y * y, np.stack([4 * x * (x * x - 1), 2 * y], axis=1)

    starts = [[-0.9, 0.1], [0.9, 0.1]]
    ends = ls.quench(many, starts, box=WELLS_BOX, batch=True)
    assert ends.x == pytest.approx(ls.quench(wells, starts, box=WELLS_BOX).x)
    heights = [
        ls.map(*which, starts, box=WELLS_BOX, **how).tree.merge_height(0, 1)
        for which, how in [((wells,), {}), ((many,), {"batch": True}), ((wells,), {"hessian": curvature})]
    ]
    assert heights == pytest.approx([1.0, 1.0, 1.0], abs=1e-6)
    with pytest.raises(ls.EnergyError, match="of the Hessian is"):
        ls.map(wells, starts, box=WELLS_BOX, hessian=lambda x: -curvature(x))


def test_hessians_are_compared_fairly():
    # Far from stationary points, slopes along one rotation after the other differ from second derivatives.
    m = np.diag([1.0, 2.0, 4.0, 7.0])
    axes = [np.array(axis) for axis in ([0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1])]

    def times(a, b):
        (p, u), (q, v) = (a[0], a[1:]), (b[0], b[1:])
        return np.concatenate([[p * q - u @ v], p * v + q * u + np.cross(u, v)])

    def form(q):
        return q @ m @ q, np.array([q @ m @ times(q, axis) for axis in axes])

    def second(q):
        return np.array([[0.5 * times(q, a) @ m @ times(q, b) - 0.5 * (a @ b) * (q @ m @ q) for a in axes] for b in axes])

    assert ls.explore(form, ls.Rotations(), hessian=second).minima.rows >= 1
    # Where all is flat, there is rounding only.
    assert ls.explore(
        lambda x: (float(np.tanh(10 * x[0]) ** 2), np.array([20 * np.tanh(10 * x[0]) / np.cosh(10 * x[0]) ** 2])),
        box=([-2.0], [2.0]),
        hessian=lambda x: np.array([[200 * (1 - 3 * np.tanh(10 * x[0]) ** 2 + 2 * np.tanh(10 * x[0]) ** 4) + 0.0]]),
    ).minima.rows >= 1


def test_frames_are_told_what_they_lack():
    with pytest.raises(ls.InputError, match="box"):
        ls.evaluate(wells, np.zeros((1, 6)), ls.FixedFrame(("Ar", "Ar"), periodic=True))
    with pytest.raises(ls.InputError, match="list of the element"):
        ls.evaluate(wells, np.zeros((1, 9)), ls.FixedFrame("Ar2"), box=(-1, 1))
    with pytest.raises(ls.InputError, match="wrap alike"):
        ls.evaluate(wells, np.zeros((1, 6)), ls.FixedFrame(("Ar", "Ar"), periodic=True), box=([0.0] * 6, [4.0, 4, 4, 5, 4, 4]))
