# SPDX-License-Identifier: Apache-2.0
"""A campaign of many runs through the verbs that read all of it; time and memory are printed."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from uuid import UUID

import numpy as np

from flatplank_control.bench.results import write_campaign
from flatplank_data.campaign import Campaign
from flatplank_data.exporters import EXPORTERS
from flatplank_validation.trust import killing as k
from flatplank_validation.trust.registry import Options, Tally, row

NIGHT = 2000
"""runs"""
FEWEST = 4
NOISE_N = 20.0
"""differs from run to run, so that no run is a copy of another"""
VERBS = ("table", "compare", "report")
PATIENCE_S = 3600.0


def grown(few: Path, count: int, folder: Path) -> Path:
    """`count` runs made of a few: the forces get noise of their own."""
    folder.mkdir()
    tables, made = list(Campaign.load(few).tables()), []
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


def measured(words: list[str], log: Path) -> tuple[int, float, float]:
    """Exit code, processor time [s] and largest memory [MB] of a program."""
    with log.open("w") as out:
        process = subprocess.Popen(words, stdout=out, stderr=out)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0


@row("many", f"a campaign of many runs through {', '.join(VERBS)}", "a verb ends with an error")
def many(o: Options) -> Tally:
    """A case is a verb."""
    out, count = Tally(), max(o.count(NIGHT), FEWEST)
    with tempfile.TemporaryDirectory(prefix="fp-many-") as top:
        folder = grown(k.campaign(Path(top) / "few"), count, Path(top) / "many")
        for verb in VERBS:
            more = ["--out", str(Path(top) / "report")] if verb == "report" else []
            began, log = time.monotonic(), Path(top) / "log"
            code, processor, memory = measured(k.verb(verb, folder, *more), log)
            lasted = time.monotonic() - began
            text = f"{verb}: {count} runs, {lasted:.1f} s, {processor:.1f} s of processor"
            print(f"{text}, {memory:.0f} MB", file=sys.stderr)
            last = (log.read_text(errors="replace").splitlines() or [""])[-1]
            out.add("" if code == 0 else f"{text}: exit {code}: {last}")
            o.progress(out.many, len(VERBS))
    return out
