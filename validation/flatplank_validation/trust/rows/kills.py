# SPDX-License-Identifier: Apache-2.0
"""Programs killed at drawn moments (kill -9): what they leave can be read, and they go on."""

from __future__ import annotations

import random
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

from flatplank_data.campaign import Campaign
from flatplank_validation.trust import killing as k
from flatplank_validation.trust.registry import Options, Tally, row

NIGHT = 10
"""moments of each program"""
BAR = "folder or model cannot be read, or the program does not go on"
SLOW_S = 60.0
"""longest time until a program is killed that only reads, or measures for longer [s]"""
Case = Callable[[Path, float], str]
"""(folder, share of the time of the whole program) -> failure"""


class Measuring:
    """The runner on the twin: resumed, it makes every run once."""

    def __init__(self, top: Path) -> None:
        self.plan, self.log = top / "killed.yaml", top / "run.log"
        self.plan.write_text(k.PLAN, encoding="utf-8")
        failed, self.time = k.whole(self._words(top / "whole"), self.log)
        if failed:
            raise RuntimeError(failed)

    def _words(self, folder: Path) -> list[str]:
        return k.verb("run", "--sim", "--jobs", "1", "--data", folder, self.plan)

    def __call__(self, folder: Path, share: float) -> str:
        k.killed_after(self._words(folder), share * self.time, self.log)
        failed, _ = k.whole(self._words(folder), self.log)
        if failed:
            return failed
        files = [run.info.file for run in Campaign.load(folder).runs]
        if len(files) != k.RUNS or len(set(files)) != k.RUNS:
            return f"{len(files)} runs, {k.RUNS} are right"
        return k.broken(folder)


class Adding:
    """`add`: the model is the old one or the new one, and the step can be made after all."""

    def __init__(self, top: Path) -> None:
        self.base, self.log = k.campaign(top / "base"), top / "add.log"
        shutil.copytree(self.base, top / "first")
        failed, self.time = k.whole(self._words(top / "first"), self.log)
        if failed:
            raise RuntimeError(failed)
        self.model = (top / "first" / "model.yaml").read_bytes()

    def _words(self, folder: Path) -> list[str]:
        return k.verb("add", "conicity", folder)

    def __call__(self, folder: Path, share: float) -> str:
        shutil.copytree(self.base, folder)
        k.killed_after(self._words(folder), share * self.time, self.log)
        if bad := k.broken(folder):
            return bad
        model = folder / "model.yaml"
        if not model.exists():
            failed, _ = k.whole(self._words(folder), self.log)
            if failed:
                return failed
        return "" if model.read_bytes() == self.model else "another model than without the kill"


class Reading:
    """`diagnose` and `propose`: they leave the campaign as it was."""

    def __init__(self, top: Path, verb: str) -> None:
        self.base, self.log, self.verb = k.campaign(top / "base"), top / "log", verb
        self.before = k.contents(self.base)

    def __call__(self, folder: Path, share: float) -> str:
        shutil.copytree(self.base, folder)
        report = folder / "report"
        words = k.verb(self.verb, folder, "--report", report)
        k.killed_after(words, share * SLOW_S, self.log)
        changed = {name for name, data in self.before.items() if k.contents(folder)[name] != data}
        return f"changed: {', '.join(sorted(changed))}" if changed else k.broken(folder)


class Investigating:
    """`investigate` on the twin: its log and its runs can be read, and it goes on with them."""

    def __init__(self, top: Path) -> None:
        self.log = top / "log"

    def __call__(self, folder: Path, share: float) -> str:
        words = k.verb("investigate", folder, "--sim", "--minutes", "30", "--jobs", "1")
        k.killed_after(words, share * SLOW_S, self.log)
        before = {p.name for p in folder.glob("*.parquet")}
        if (code := k.killed_after(words, SLOW_S, self.log)) > 0:
            last = (self.log.read_text(errors="replace").splitlines() or [""])[-1]
            return f"exit {code}: {last}"
        gone = before - {p.name for p in folder.glob("*.parquet")}
        if gone:
            return f"lost: {', '.join(sorted(gone))}"
        return k.broken(folder) if (folder / "campaign.yaml").exists() else ""


class Showing:
    """The panel: started again on the same folder and port it shows its page."""

    def __init__(self, top: Path) -> None:
        self.data, self.log = k.campaign(top / "base"), top / "log"

    def __call__(self, folder: Path, share: float) -> str:
        port, token = k.free_port(), "of_a_test"
        words = k.verb("panel", "--port", str(port), "--token", token, "--data", self.data)
        k.killed_after(words, share * SLOW_S / 3.0, self.log)
        process = k.started(words, self.log)
        try:
            return k.answers(port, process, token) or k.broken(self.data)
        finally:
            k.end(process)


PROGRAMS: dict[str, Callable[[Path], Case]] = {
    "run": Measuring,
    "add": Adding,
    "diagnose": lambda top: Reading(top, "diagnose"),
    "propose": lambda top: Reading(top, "propose"),
    "investigate": Investigating,
    "panel": Showing,
}
"""verb -> what is made ready once, and then tried at each moment"""


@row("kills", f"kill -9 of {', '.join(PROGRAMS)} at drawn moments", BAR)
def kills(o: Options) -> Tally:
    """The moments are spread over the time of the whole program, or over a minute."""
    out, each, draw = Tally(), o.count(NIGHT), random.Random(o.seed)
    for name, make in PROGRAMS.items():
        with tempfile.TemporaryDirectory(prefix="fp-kills-", ignore_cleanup_errors=True) as top:
            case = make(Path(top))
            for i in range(each):
                share = (i + draw.random()) / each
                failed = case(Path(top) / f"case_{i}", share)
                out.add(f"{name} at {100 * share:.0f} %: {failed}" if failed else "")
                o.progress(out.many, each * len(PROGRAMS))
    return out
