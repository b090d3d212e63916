# SPDX-License-Identifier: Apache-2.0
"""Measures the start of each node until it is connected, with warm and with cold caches.

`--write` writes the table to docs/tutorial/start.md.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
import time
from pathlib import Path

from flatplank_control.bench.fast_dds import loopback_environment
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.nodes.client import BenchClient
from flatplank_validation.bench.cold_start import forget_files, without_byte_code

PAGE = Path(__file__).resolve().parents[2] / "docs/tutorial/start.md"
MIB = 1024.0
"""[kB]"""
Row = tuple[float, float, float]
"""time until connected [s], processor time [s], memory [MiB]"""


def memory(pid: int) -> float:
    """Largest resident memory of a process so far [MiB]."""
    found = re.search(r"VmHWM:\s+(\d+)", Path(f"/proc/{pid}/status").read_text())
    return int(found[1]) / MIB if found else float("nan")


def start(environment: dict[str, str]) -> dict[str, Row]:
    """Start a bench with these environment variables added, and end it; returns the numbers of its
    nodes."""
    with tempfile.TemporaryDirectory() as folder, BenchClient() as client:
        setup, log = BenchSetup(pace="hold", data=folder), Path(folder) / "nodes.log"
        begin = time.monotonic()
        with BenchProcesses(setup, environment=environment, log=log) as bench:
            up_at = client.wait_connected(bench)
            vitals = bench.vitals()
            return {
                name: (up_at[name] - begin, vitals[name].cpu_s, memory(process.pid))
                for name, process in bench.running.items()
            }


def table(warm: dict[str, Row], cold: dict[str, Row]) -> list[str]:
    """Lines of a Markdown table; the last row has the slowest node and the sums."""
    head = "connected after [s] | processor [s] | memory [MiB]"
    lines = [f"| node | warm: {head} | cold: {head} |", "|---|--:|--:|--:|--:|--:|--:|"]
    for name in warm:
        lines.append(f"| {name} | {numbers(warm[name])} | {numbers(cold[name])} |")
    return [*lines, f"| **all** | {numbers(total(warm))} | {numbers(total(cold))} |"]


def numbers(row: Row) -> str:
    seconds, cpu, mib = row
    return f"{seconds:.1f} | {cpu:.1f} | {mib:.0f}"


def total(rows: dict[str, Row]) -> Row:
    seconds, cpu, mib = zip(*rows.values(), strict=True)
    return max(seconds), sum(cpu), sum(mib)


def main() -> int:
    os.environ.update(loopback_environment())
    start({})  # a first start warms all caches
    warm = start({})
    with tempfile.TemporaryDirectory() as folder:
        files = forget_files()
        cold = start(without_byte_code(Path(folder)))
    lines = table(warm, cold)
    load = f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the end"
    print(f"start of a bench in pace hold ({load}; cold: {files} files read from disk anew,")
    print("no byte code, no compiled kernels):")
    print("\n".join(lines))
    if "--write" in sys.argv:
        text = PAGE.read_text(encoding="utf-8")
        block = "\n".join(["<!-- table -->", *lines, "", f"Measured on {load}.", "<!-- end -->"])
        PAGE.write_text(
            re.sub("<!-- table -->.*<!-- end -->", block, text, flags=re.DOTALL), encoding="utf-8"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
