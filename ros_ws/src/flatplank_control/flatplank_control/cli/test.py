# SPDX-License-Identifier: Apache-2.0
"""Run the project's tests: [--long] [-k EXPR] [FILE ...]; further options go to pytest."""

from __future__ import annotations

import os
import sys

from flatplank_control.cli.root import project_root

# One thread per process: two cores are shared by the nodes of a graph, and numbers repeat.
# Fast DDS: UDP on loopback, for shared memory leaves locks behind when a test kills a node.
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MPLBACKEND": "Agg",
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
}


def main(argv: list[str]) -> int:
    """Become pytest, in the checkout: its closing line is the last, its exit code ours."""
    os.chdir(project_root())
    environment = {**os.environ, **ENVIRONMENT}
    sys.stdout.flush()
    os.execve(sys.executable, [sys.executable, "-m", "pytest", *argv], environment)
