"""Runs a landscape command with HyperQueue, and joins the journals of its workers at the end.

    python hq.py 64 build grasps.parquet
    python hq.py --local 4 synth --object mug.obj -n 1000 -o mug.parquet

The first word is the number of workers; the others are the command. Needs `pip install hyperqueue` and a server (`hq server
start`, with workers on nodes that see the working folder); with --local it starts both on this machine.
CPUS is the number of cores of each worker (4).
"""

import contextlib
import os
import shutil
import sys
import tempfile

from hyperqueue import Client, Job, LocalCluster
from hyperqueue.ffi.protocol import ResourceRequest


def main() -> None:
    words = sys.argv[1:]
    local = "--local" in words[:1]
    count, *command = words[local:]
    cpus = int(os.environ.get("CPUS", "4"))
    program = [os.environ.get("LANDSCAPE") or shutil.which("landscape") or "landscape", *command]
    program += ["--threads", str(cpus)]
    with contextlib.ExitStack() as stack:
        if local:
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            cluster = stack.enter_context(LocalCluster(folder))
            cluster.start_worker()
            client = cluster.client()
        else:
            client = Client()
        job = Job(default_workdir=".", max_fails=None, name="landscape")
        resources = ResourceRequest(cpus=cpus)
        shares = [
            job.program(
                [*program, "--worker", f"{number}/{count}"],
                name=f"worker-{number}",
                stdout=None,
                stderr=f"landscape-worker-{number}.log",
                resources=resources,
            )
            for number in range(1, int(count) + 1)
        ]
        job.program(
            program,
            name="join",
            deps=shares,
            stdout=None,
            stderr="landscape-join.log",
            resources=resources,
        )
        client.wait_for_jobs([client.submit(job)])


main()
