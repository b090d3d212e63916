# SPDX-License-Identifier: Apache-2.0
"""A campaign of many runs through all that reads the whole of it; time and memory are printed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from uuid import UUID

import numpy as np

from flatplank_control.bench.results import write_campaign
from flatplank_data.campaign import Campaign
from flatplank_data.exporters import EXPORTERS
from flatplank_panel.signals import OVER
from flatplank_validation.trust import killing as k
from flatplank_validation.trust.registry import Options, Tally, row

NIGHT = 2000
"""runs"""
FEWEST = 4
NOISE_N = 20.0
"""differs from run to run, so that no run is a copy of another"""
SAMPLES = 5000
"""of a run: 20 s at 250 Hz, 0.6 m of road, the step in the middle"""
DRAWN = 60
"""curves of the page"""
LOOK_S = 0.05
"""time from one look at the memory to the next [s]"""
PATIENCE_S = 3600.0
"""a program that takes longer hangs [s]"""


def page(folder: Path) -> str:
    """What the page Runs asks of its worker: campaigns, list of runs, curves."""
    files = [run.info.file for run in Campaign.load(folder).runs[:DRAWN]]
    wanted = {
        "campaigns": {"root": str(folder)},
        "runs": {"folder": str(folder)},
        "curves": {
            "folder": str(folder),
            "files": files,
            "channel": "fx",
            "over": next(iter(OVER)),
        },
    }
    return "".join(json.dumps({"do": do, "with": w}) + "\n" for do, w in wanted.items())


READERS: dict[str, Callable[[Path], list[str]]] = {
    "table": lambda folder: k.verb("table", folder),
    "compare": lambda folder: k.verb("compare", folder),
    "report": lambda folder: k.verb("report", folder, "--out", folder.parent / "report"),
    "page": lambda _folder: [sys.executable, "-m", "flatplank_panel.analysis.worker"],
}
"""name -> command line"""


def grown(few: Path, count: int, folder: Path) -> Path:
    """`count` runs made of a few: the forces get noise of their own."""
    folder.mkdir()
    tables = [table.rows(slice(0, SAMPLES)) for table in Campaign.load(few).tables()]
    made = []
    for i in range(count):
        table, draw = tables[i % len(tables)], np.random.default_rng(i)
        noise = draw.normal(0.0, NOISE_N, len(table))
        columns = {**table.columns, "fx": table["fx"] + noise}
        info = replace(
            table.info, file=f"run_{i:04d}.parquet", uuid=str(UUID(int=i + 1)), repeat=i
        )
        new = replace(table, columns=columns, info=info)
        EXPORTERS[".parquet"](new, folder / info.file)
        made.append((info.to_dict(), info.file))
    write_campaign(folder, tables[0].info.tire, made)
    return folder


def measured(words: list[str], asked: str, log: Path) -> tuple[int, float, float]:
    """Exit code, processor time [s] and largest memory [MB] of a program that is `asked`."""
    log.with_suffix(".in").write_text(asked, encoding="utf-8")
    with log.open("w") as out, log.with_suffix(".in").open() as said:
        process = subprocess.Popen(words, stdin=said, stdout=out, stderr=out)
    ended, memory, began = 0, 0.0, time.monotonic()
    while not ended:
        memory = max(memory, _memory(process.pid))
        time.sleep(LOOK_S)
        if time.monotonic() - began > PATIENCE_S:
            process.kill()
        ended, status, used = os.wait4(process.pid, os.WNOHANG)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, used.ru_utime + used.ru_stime, memory


def _memory(pid: int) -> float:
    """Largest memory until now [MB]; that of `wait4` counts the memory of the parent, too."""
    text = Path(f"/proc/{pid}/status").read_text()
    return float(text.partition("VmHWM:")[2].split()[0]) / 1024.0 if "VmHWM:" in text else 0.0


def complaint(code: int, asked: str, log: Path) -> str:
    """Empty, or why a program has failed; one that is asked answers each question."""
    lines = log.read_text(errors="replace").splitlines() or [""]
    answers = sum('"result"' in line[:20] for line in lines)
    if code == 0 and answers == (asked.count("\n") if asked else answers):
        return ""
    return f"exit {code}: {lines[-1][:200]}"


@row("many", f"a campaign of many runs through {', '.join(READERS)}", "it ends with an error")
def many(o: Options) -> Tally:
    """A case is a program."""
    out, count = Tally(), max(o.count(NIGHT), FEWEST)
    with tempfile.TemporaryDirectory(prefix="fp-many-") as top:
        folder = grown(k.campaign(Path(top) / "few"), count, Path(top) / "many")
        for name, words in READERS.items():
            asked = page(folder) if name == "page" else ""
            began, log = time.monotonic(), Path(top) / "log"
            code, processor, memory = measured(words(folder), asked, log)
            lasted = time.monotonic() - began
            text = f"{name}: {count} runs, {lasted:.1f} s, {processor:.1f} s of processor"
            out.notes.append(f"{text}, {memory:.0f} MB")
            print(out.notes[-1], file=sys.stderr)
            failed = complaint(code, asked, log)
            out.add(f"{text}: {failed}" if failed else "")
            o.progress(out.many, len(READERS))
    return out
