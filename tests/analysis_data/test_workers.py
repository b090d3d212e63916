# SPDX-License-Identifier: Apache-2.0
"""Workers have one core each, and end by themselves when their process is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from flatplank_analysis.parallel import available_cores

WAITS = """
import multiprocessing, os, sys, time
from flatplank_analysis.parallel import worker_pool
if __name__ == "__main__":
    with worker_pool(2, multiprocessing.get_context(sys.argv[1])) as pool:
        pids = set()
        while len(pids) < 2:
            pids |= {job.result() for job in [pool.submit(os.getpid) for _ in range(8)]}
        print(*pids, flush=True)
        pool.submit(time.sleep, 600.0).result()
"""


def _alive(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as stream:
            return stream.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("context", ["spawn", "forkserver"])
def test_workers_end_when_their_parent_is_killed(context, tmp_path) -> None:
    script = tmp_path / "waits.py"
    script.write_text(WAITS)
    words = [sys.executable, str(script), context]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as parent:
        workers = [int(word) for word in parent.stdout.readline().split()]
        assert len(workers) == 2 and all(map(_alive, workers))
        os.kill(parent.pid, signal.SIGKILL)
    end = time.monotonic() + 60.0
    while any(map(_alive, workers)):
        assert time.monotonic() < end, [pid for pid in workers if _alive(pid)]
        time.sleep(0.02)


THREADS = """
import multiprocessing
from flatplank_analysis.parallel import worker_pool
MODEL = "flatplank_analysis.contact_patch.model"
COUNT = f"__import__('{MODEL}', fromlist=['threads']).threads() is None"
if __name__ == "__main__":
    server = multiprocessing.get_context("forkserver")
    server.set_forkserver_preload([MODEL])
    with worker_pool(1, server) as pool:
        print(eval(COUNT), pool.submit(eval, COUNT).result())
"""


def test_a_worker_has_one_core_of_its_own_also_where_its_server_read_the_model(tmp_path) -> None:
    script = tmp_path / "threads.py"
    script.write_text(THREADS)
    told = subprocess.run([sys.executable, str(script)], stdout=subprocess.PIPE, text=True)
    assert told.stdout.split() == [str(available_cores() == 1), "True"]
