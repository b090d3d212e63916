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

from ethercat_contract import WITHIN_MS
from ethercat_handlers import MUTATIONS, Mutation
from ethercat_others import OTHERS
from ethercat_scenarios import SCENARIOS

ROOT = Path(__file__).parents[2]
PACKAGE = "ros_ws/src/flatplank_hw"
CODE = "flatplank_hw/ethercat"
HEAD = """# Faults of the EtherCAT bus, one by one

Written by `python tests/ethercat/ethercat_mutations.py --docs docs/reference/ethercat-faults.md`;
what the tests assert is explained in [ethercat.md](../guide/ethercat.md#faults). *At rest*: from
the fault to the last motion of the wheel's shaft, in bench time, at most {bound:g} ms; *turns*:
the wheel may turn on, and does. *Noticed*: changes of the code with which the fault's test
fails.
After each fault on a running bus nothing is enabled by itself, and the wheel turns again after an
explicit reset.

"""

LIMIT_S = 240
"""without a handler a run may take for ever"""


def copied(folder: Path) -> Path:
    """The package and its tests, in a folder where they may be broken."""
    shutil.copytree(ROOT / PACKAGE, folder / PACKAGE, symlinks=True)
    themselves = shutil.ignore_patterns("test_ethercat_handlers.py")
    shutil.copytree(ROOT / "tests/ethercat", folder / "tests/ethercat", ignore=themselves)
    return folder


def place(root: Path, mutation: Mutation) -> Path:
    """The file that has the handler."""
    return root / PACKAGE / CODE / mutation.file


def tests(folder: Path, select: str, *more: str, limit_s: float = LIMIT_S) -> str:
    """What running some of the tests on the copy in a folder prints."""
    words = [sys.executable, "-m", "pytest", "tests/ethercat", "-k", select, *more]
    words += ["-m", "not long", "-p", "no:cacheprovider", "-c", str(ROOT / "pyproject.toml")]
    with tempfile.TemporaryFile("w+") as out:
        try:
            subprocess.run(
                [*words, "--rootdir", str(folder)],
                cwd=folder,
                env={
                    **os.environ,
                    "PYTHONPATH": f"{folder / PACKAGE}:{folder / 'tests/ethercat'}",
                },
                stdout=out,
                stderr=subprocess.STDOUT,
                timeout=limit_s,
                check=False,
            )
        except subprocess.TimeoutExpired:
            bury(folder)
        out.seek(0)
        return out.read()


def run(mutation: Mutation, folder: Path) -> list[str]:
    """Names of the tests that fail without a handler."""
    path = place(folder, mutation)
    text = path.read_text()
    if text.count(mutation.old) != 1:
        return []
    path.write_text(text.replace(mutation.old, mutation.new))
    try:
        out = tests(folder, mutation.select, "-v")
        return list(dict.fromkeys(re.findall(r"::(\S.*?) (?:FAILED|ERROR) ", out)))
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


def at_rest(folder: Path) -> dict[str, float]:
    """Fault -> ms to the last motion of the wheel, with all handlers in place."""
    out = tests(folder, "fault or processes", "-q", "-s")
    print(out.strip().splitlines()[-1], flush=True)
    found = re.findall(r"^\W*(.+): the wheel rests after (\S+) ms$", out, re.M)
    return {name: float(ms) for name, ms in found}


def known(path: Path | None) -> dict[str, list[str]]:
    """Results of a run before, as it has printed them."""
    if path is None or not path.exists():
        return {}
    lines = (line.partition(": ") for line in path.read_text().splitlines())
    names = {m.name for m in MUTATIONS}
    return {name: tests.split("; ") for name, _, tests in lines if name in names}


def main(arguments: list[str] | None = None) -> int:
    """Exit code 1 when a handler is missed by nobody."""
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("names", nargs="*", help="parts of names of handlers; default: all")
    p.add_argument("--docs", type=Path, help="write the table of all faults to this file")
    p.add_argument("--known", type=Path, help="what an earlier run has printed: not made again")
    o = p.parse_args(arguments)
    wanted = [m for m in MUTATIONS if not o.names or any(n in m.name for n in o.names)]
    noticed = known(o.known)
    with tempfile.TemporaryDirectory(prefix="fp-mutants-") as name:
        folder = copied(Path(name))
        for mutation in wanted:
            if mutation.name not in noticed:
                noticed[mutation.name] = run(mutation, folder)
            tests_named = "; ".join(noticed[mutation.name])
            print(f"{mutation.name}: {tests_named or 'NOT NOTICED'}", flush=True)
        if o.docs:
            text = HEAD.format(bound=WITHIN_MS) + table(at_rest(folder), noticed)
            o.docs.write_text(text, encoding="utf-8")
    return 0 if all(noticed.values()) else 1


if __name__ == "__main__":
    raise SystemExit(main())
