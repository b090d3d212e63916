# SPDX-License-Identifier: Apache-2.0
"""Takes one handler out at a time, in a copy, and shows which fault tests notice.

`python tests/ethercat/ethercat_mutations.py [NAME ...]` prints what notices;
`python tests/ethercat/ethercat_mutations.py --docs FILE` writes the table of all faults.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from ethercat_contract import WITHIN_MS
from ethercat_handlers import MUTATIONS, Mutation
from ethercat_others import OTHERS
from ethercat_scenarios import SCENARIOS

ROOT = Path(__file__).parents[2]
PACKAGE = "ros_ws/src/flatplank_hw"
CODE = "flatplank_hw/ethercat"
HEAD = """# Faults of the EtherCAT bus, one by one

Written by `python tests/ethercat/ethercat_mutations.py --docs docs/ethercat-faults.md`; what the
tests assert is explained in [ethercat.md](ethercat.md#faults). *At rest*: from the fault to the
last motion of the wheel's shaft, in bench time, at most {bound:g} ms; *turns*: the wheel may turn
on, and does. *Noticed*: the fault's test fails when this handler is taken out. After each fault on
a running bus nothing is enabled by itself, and the wheel turns again after an explicit reset.

"""


class Seen(NamedTuple):
    """What a run of the tests shows."""

    failed: list[str]
    rests: dict[str, float]
    """fault -> ms from it to the last motion of the wheel"""
    summary: str


def tests(folder: Path, select: str) -> Seen:
    """Run some of the tests on the copy in a folder."""
    words = [sys.executable, "-m", "pytest", "tests/ethercat", "-q", "-s", "-k", select]
    words += ["-m", "not long", "-p", "no:cacheprovider", "-c", str(ROOT / "pyproject.toml")]
    result = subprocess.run(
        [*words, "--rootdir", str(folder)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": f"{folder / PACKAGE}:{folder / 'tests/ethercat'}"},
        capture_output=True,
        text=True,
        check=False,
    )
    out = result.stdout
    failed = re.findall(r"^(?:FAILED|ERROR) \S+::(.+?)(?: - .*)?$", out, re.M)
    if "Timeout" in out + result.stderr:
        failed.append("the run does not end")
    rests = re.findall(r"^\W*(.+): the wheel rests after (\S+) ms$", out, re.M)
    summary = out.strip().splitlines()[-1:] or [result.stderr[-200:]]
    return Seen(failed, {name: float(ms) for name, ms in rests}, summary[0])


def run(mutation: Mutation, folder: Path) -> list[str]:
    """Names of the tests that fail without a handler."""
    path = folder / PACKAGE / CODE / mutation.file
    text = path.read_text()
    if text.count(mutation.old) != 1:
        return []
    path.write_text(text.replace(mutation.old, mutation.new))
    try:
        return tests(folder, mutation.select).failed
    finally:
        path.write_text(text)
        bury(folder)


def bury(folder: Path) -> None:
    """End what a mutant has left running: its command line carries the folder."""
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_bytes()
        except OSError:
            continue
        if str(folder).encode() in words and int(entry.name) != os.getpid():
            os.kill(int(entry.name), signal.SIGKILL)


def faults() -> Iterator[tuple[str, list[str]]]:
    """Test, and the first cells of its row; name first."""
    for s in SCENARIOS:
        yield f"test_fault[{s.name}]", [s.name, s.cause, s.signature]
    for o in OTHERS:
        cause = o.cause if o.when != "at the start" else f"{o.cause}, {o.when}"
        yield o.test, [o.name, cause, o.signature]


def table(rests: dict[str, float], noticed: dict[str, list[str]]) -> str:
    """Markdown."""
    still = {s.name for s in SCENARIOS if not s.stops} | {"second master"}
    lines = ["| fault | cause | signature | at rest | noticed |", "|---|---|---|---|---|"]
    for test, cells in faults():
        name = cells[0]
        rest = "turns" if name in still else f"{rests[name]:g} ms" if name in rests else "-"
        names = [m for m, failed in noticed.items() if any(f.startswith(test) for f in failed)]
        lines.append("| " + " | ".join([*cells, rest, "; ".join(names) or "-"]) + " |")
    missed = [name for name, failed in noticed.items() if not failed]
    lines += ["", f"{len(noticed)} handlers were taken out; noticed by no test: "]
    lines[-1] += ", ".join(missed) or "none."
    other = {m: failed for m, failed in noticed.items() if m not in "\n".join(lines)}
    lines += [f"Noticed by other tests: {m} ({', '.join(f)})." for m, f in other.items() if f]
    return "\n".join(lines) + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Exit code 1 when a handler is missed by nobody."""
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("names", nargs="*", help="parts of names of handlers; default: all")
    p.add_argument("--docs", type=Path, help="write the table of all faults to this file")
    o = p.parse_args(arguments)
    wanted = [m for m in MUTATIONS if not o.names or any(n in m.name for n in o.names)]
    noticed: dict[str, list[str]] = {}
    with tempfile.TemporaryDirectory(prefix="fp-mutants-") as name:
        folder = Path(name)
        shutil.copytree(ROOT / PACKAGE, folder / PACKAGE, symlinks=True)
        shutil.copytree(ROOT / "tests/ethercat", folder / "tests/ethercat")
        well = tests(folder, "fault or processes") if o.docs else Seen([], {}, "")
        if well.failed:
            print(f"fails with all handlers in place: {well.failed}", file=sys.stderr)
        for mutation in wanted:
            noticed[mutation.name] = run(mutation, folder)
            print(
                f"{mutation.name}: {'; '.join(noticed[mutation.name]) or 'NOT NOTICED'}",
                flush=True,
            )
    if o.docs:
        text = HEAD.format(bound=WITHIN_MS) + table(well.rests, noticed)
        o.docs.write_text(text, encoding="utf-8")
    return 0 if all(noticed.values()) and not well.failed else 1


if __name__ == "__main__":
    raise SystemExit(main())
