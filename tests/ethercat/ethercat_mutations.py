# SPDX-License-Identifier: Apache-2.0
"""Takes one handler out at a time, in a copy, and shows which fault tests notice.

`python tests/ethercat/ethercat_mutations.py [NAME ...]`; prints the table of docs/ethercat.md.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PACKAGE = "ros_ws/src/flatplank_hw"
CODE = "flatplank_hw/ethercat"


class Mutation(NamedTuple):
    """A handler that is taken out."""

    name: str
    file: str
    old: str
    new: str
    select: str
    """tests to run (-k)"""


MUTATIONS = (
    Mutation(
        "guard ignores the health of the bus",
        "master/guard.py",
        "if inputs is None or health not in (Health.OK, Health.DEGRADED):",
        "if inputs is None:",
        "fault and (answers or counter or cut)",
    ),
    Mutation(
        "guard does not latch",
        "master/guard.py",
        "self.latched[axis] = cause",
        "self.latched.pop(axis, None)",
        "fault and (eight or answers or emergency)",
    ),
    Mutation(
        "guard ignores the emergency stop contact",
        "master/guard.py",
        "if not inputs.digital & Digital.EMERGENCY_STOP_OK:",
        "if False:",
        "emergency_stop or (fault and contact)",
    ),
    Mutation(
        "guard ignores old commands",
        "master/guard.py",
        "if cycle - command.cycle > self.timeout:",
        "if False:",
        "node_silent",
    ),
    Mutation(
        "guard ignores limit switches",
        "master/guard.py",
        "closed & _LIMITS.get(axis, 0)",
        "False",
        "fault and limit",
    ),
    Mutation(
        "a stop is lifted without a reset",
        "master/guard.py",
        "if reset and not self._reset_seen.get(axis, True) and not cause:",
        "if not cause:",
        "fault and (eight or answers or contact)",
    ),
    Mutation(
        "single losses are not tolerated",
        "master/health.py",
        "TOLERATED = 2",
        "TOLERATED = 0",
        "fault and lost",
    ),
    Mutation(
        "losses are never called lost",
        "master/health.py",
        "TOLERATED = 2",
        "TOLERATED = 10**9",
        "fault and (eight or counter or answers)",
    ),
    Mutation(
        "the working counter is not compared",
        "master/health.py",
        "good = seen.arrived and seen.counter == self.expected",
        "good = seen.arrived",
        "fault and counter",
    ),
    Mutation(
        "the echo is not compared",
        "master/health.py",
        "if seen.arrived and not seen.echo_ok:",
        "if False:",
        "fault and held",
    ),
    Mutation(
        "AL states are not read",
        "master/loop.py",
        "self.monitor.states(self.soem.states())\n        elif",
        "pass\n        elif",
        "fault and SAFEOP",
    ),
    Mutation(
        "the socket is not reopened",
        "master/soem.py",
        "        self._master.close()\n        self.open()",
        "        return",
        "(fault and held) or foreign",
    ),
    Mutation(
        "slaves in SAFEOP are not brought back",
        "master/soem.py",
        'if slave.state & 0x0F == STATES["SAFEOP"]:',
        "if False:",
        "fault and maker",
    ),
    Mutation(
        "slaves that lost their state are not configured again, nor is the bus scanned",
        "master/ladder.py",
        "return Rung.RECONFIGURE\n        return Rung.RESCAN",
        "return Rung.NONE\n        return Rung.NONE",
        "fault and (PREOP or INIT or restarts)",
    ),
    Mutation(
        "no full scan",
        "master/ladder.py",
        "return Rung.RESCAN",
        "return Rung.NONE",
        "long_cut or another_slave",
    ),
    Mutation(
        "identities are not checked",
        "master/identity.py",
        "same = (vendor, product) == (spec.vendor, spec.product)",
        "same = True",
        "identity or another_slave",
    ),
    Mutation(
        "no lock on the interface",
        "master/interface.py",
        "fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)",
        "pass",
        "second_master",
    ),
    Mutation(
        "watchdogs are not set",
        "master/soem.py",
        "ticks = self.bus.watchdog_ms * 1_000_000 // WATCHDOG_DIVIDER_NS",
        "ticks = 0",
        "killed or frozen",
    ),
    Mutation(
        "the death of the node is not noticed",
        "master/loop.py",
        "while self.running and not self.link.parent_gone:",
        "while self.running:",
        "node_killed",
    ),
    Mutation(
        "the bus ends without stopping the axes",
        "master/loop.py",
        "            self.turn()\n        self._stop_axes()",
        "            self.turn()",
        "stopping_the_bus",
    ),
    Mutation(
        "no images while the bus process is silent",
        "master/client.py",
        "return [self._invent(now)]",
        "return []",
        "bus_process_killed",
    ),
    Mutation(
        "SDO time-out of the library",
        "master/soem.py",
        "SDO_TIMEOUT_US = 20_000",
        "SDO_TIMEOUT_US = 700_000",
        "sdo_services",
    ),
    Mutation(
        "mailboxes are not looked into",
        "master/soem.py",
        "            self._master.slaves[number].mbx_receive()",
        "            return",
        "fault and message",
    ),
    Mutation(
        "a reset in a burst gets lost",
        "master/inbox.py",
        "shown.add(axis)",
        "pass",
        "burst",
    ),
)


def run(mutation: Mutation, folder: Path) -> str:
    """Names of the tests that fail, or what went wrong."""
    path = folder / PACKAGE / CODE / mutation.file
    text = path.read_text()
    if text.count(mutation.old) != 1:
        return f"NOT APPLIED: found {text.count(mutation.old)} times"
    path.write_text(text.replace(mutation.old, mutation.new))
    try:
        words = [sys.executable, "-m", "pytest", "tests/ethercat", "-q", "-k", mutation.select]
        words += ["-m", "not long", "-p", "no:cacheprovider", "-c", str(ROOT / "pyproject.toml")]
        paths = f"{folder / PACKAGE}:{folder / 'tests/ethercat'}"
        result = subprocess.run(
            [*words, "--rootdir", str(folder)],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": paths},
            capture_output=True,
            text=True,
            check=False,
        )
    finally:
        path.write_text(text)
        bury(folder)
    failed = re.findall(r"^(?:FAILED|ERROR) \S+::(.+?)(?: - .*)?$", result.stdout, re.M)
    if "Timeout" in result.stdout + result.stderr:
        failed.append("the run does not end")
    summary = result.stdout.strip().splitlines()[-1:] or [result.stderr[-200:]]
    return "; ".join(failed) if failed else f"NOT NOTICED ({summary[0]})"


def bury(folder: Path) -> None:
    """End what a mutant has left running: its command line carries the folder."""
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_bytes()
        except OSError:
            continue
        if str(folder).encode() in words and int(entry.name) != os.getpid():
            os.kill(int(entry.name), signal.SIGKILL)


def main(names: list[str]) -> int:
    """One row per mutation; exit code 1 when one is not noticed."""
    wanted = [m for m in MUTATIONS if not names or any(n in m.name for n in names)]
    good = True
    with tempfile.TemporaryDirectory(prefix="fp-mutants-") as name:
        folder = Path(name)
        shutil.copytree(ROOT / PACKAGE, folder / PACKAGE, symlinks=True)
        shutil.copytree(ROOT / "tests/ethercat", folder / "tests/ethercat")
        print("| handler taken out | tests that fail |\n|---|---|")
        for mutation in wanted:
            outcome = run(mutation, folder)
            good &= not outcome.startswith("NOT")
            print(f"| {mutation.name} | {outcome} |", flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
