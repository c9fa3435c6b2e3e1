"""What a question to another program costs within a search -> figures/external_calls.md

    cargo build --release
    python3 analysis/external_calls/run.py target/release/landscape

Thirty double wells are a loop in Python that answers `landscape surface`. The cost of a point is the time of the search on
one thread, divided by the number of points, less the time of the loop on bytes in memory. The work of the search itself is
included, so that the numbers are upper bounds of the overhead. The same is measured with both programs on one core, and with a
thread and a loop for each core.
"""

import io
import json
import os
import struct
import subprocess
import sys
import tempfile
import time

OUTPUT = "figures/external_calls.md"
DIMENSIONS = 30
SEARCHES = 400
REPEATS = 3


def energy_and_gradient(x):
    energy, gradient = 0.0, []
    for value in x:
        inner = value * value - 1.0
        energy += inner * inner + 0.1 * value
        gradient.append(4.0 * value * inner + 0.1)
    return energy, gradient


def json_loop(source, sink):
    while line := source.readline():
        energy, gradient = energy_and_gradient(json.loads(line)["x"])
        sink.write(json.dumps({"energy": energy, "gradient": gradient}).encode() + b"\n")
        sink.flush()


def binary_loop(source, sink):
    question, answer = struct.Struct(f"<{DIMENSIONS}d"), struct.Struct(f"<{DIMENSIONS + 1}d")
    while data := source.read(question.size):
        energy, gradient = energy_and_gradient(question.unpack(data))
        sink.write(answer.pack(energy, *gradient))
        sink.flush()


def batch_loop(source, sink):
    question, answer = struct.Struct(f"<{DIMENSIONS}d"), struct.Struct(f"<{DIMENSIONS + 1}d")
    while header := source.read(8):
        data = source.read(question.size * struct.unpack("<Q", header)[0])
        told = [energy_and_gradient(point) for point in question.iter_unpack(data)]
        sink.write(b"".join(answer.pack(energy, *gradient) for energy, gradient in told))
        sink.flush()


LOOPS = {"json": json_loop, "binary": binary_loop, "batch": batch_loop}


def own_time(protocol, points=20000):
    """Microseconds of the loop alone for each point."""
    x = [0.25 + 0.01 * k for k in range(DIMENSIONS)]
    packed = struct.pack(f"<{DIMENSIONS}d", *x)
    text = json.dumps({"x": x}).encode() + b"\n"
    whole = {"json": text * points, "binary": packed * points, "batch": (struct.pack("<Q", 60) + packed * 60) * (points // 60)}
    best = []
    for _ in range(5):
        began = time.process_time()
        LOOPS[protocol](io.BytesIO(whole[protocol]), io.BytesIO())
        best.append(1e6 * (time.process_time() - began) / points)
    return min(best)


def measured(binary, protocol, threads=1, pinned=False):
    """Questions, and seconds of the search by the clock, summed over threads."""
    with tempfile.TemporaryDirectory() as folder:
        command = f"exec {sys.executable} {os.path.abspath(__file__)} --serve {protocol}"
        arguments = [binary, "surface", "--command", command, f"--region=-1.5:1.5x{DIMENSIONS}", "--protocol", protocol, "--search", "all",
                     "--searches", str(SEARCHES), "--threads", str(threads), "-q", "--no-report", "-o", os.path.join(folder, "out")]
        if pinned:
            arguments = ["taskset", "-c", str(min(os.sched_getaffinity(0))), *arguments]
        subprocess.run(arguments, check=True, cwd=folder)
        calls = json.load(open(os.path.join(folder, "out/landscape.json")))["counts"]["evaluations"]
        phases = json.load(open(os.path.join(folder, "out/timings.json")))["phases"]
        return calls, threads * sum(phase["seconds"] for phase in phases if phase["evaluations"])


def main(binary):
    binary = os.path.abspath(binary)
    load = os.getloadavg()[0]
    lines, points = [], None
    for protocol, name in (("json", "text, one by one"), ("binary", "binary, one by one"), ("batch", "batches for Hessians, other points one by one")):
        own = own_time(protocol)
        places = {"any core": {}, "one core": {"pinned": True}, f"all {os.cpu_count()} cores": {"threads": os.cpu_count()}}
        for where, settings in places.items():
            runs = [measured(binary, protocol, **settings) for _ in range(REPEATS)]
            # The search is the same with every protocol, but a Hessian asked for in a batch counts as one evaluation.
            points = points or runs[0][0]
            clock = 1e6 * min(seconds for _, seconds in runs) / points
            cells = [name, where, points, *(f"{value:.1f}" for value in (clock, own, clock - own))]
            lines.append("| " + " | ".join(str(cell) for cell in cells) + " |\n")
            print(lines[-1], runs, flush=True)
    text = (
        f"# What a question to another program costs\n\nMade by `analysis/external_calls/run.py`: {SEARCHES} searches on {DIMENSIONS} double wells, "
        "whose energy is a loop in Python. Each number is the least of "
        f"{REPEATS} runs, in µs for each point. The overhead is the time beyond that of the loop on bytes in memory; it includes the work of the search "
        "itself. “One core” means that both programs were kept on one core with `taskset`; “all cores” that each of as many threads asked a loop of its "
        "own, where the time of the clock counts once for each thread. Before these runs the machine of "
        f"{os.cpu_count()} cores had a load of {load:.1f}.\n\n"
        "| protocol | runs on | points | time | loop alone | overhead |\n|---|---|---|---|---|---|\n"
        + "".join(lines))
    with open(OUTPUT + ".new", "w") as file:
        file.write(text)
    os.replace(OUTPUT + ".new", OUTPUT)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        LOOPS[sys.argv[2]](sys.stdin.buffer, sys.stdout.buffer)
    elif len(sys.argv) == 2:
        main(sys.argv[1])
    else:
        sys.exit(__doc__)
