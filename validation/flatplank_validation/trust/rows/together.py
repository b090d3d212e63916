# SPDX-License-Identifier: Apache-2.0
"""Several programs on one folder, and a folder that moves away under an open page."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

from flatplank_analysis.discovery.modelfile import load_model
from flatplank_data.campaign import Campaign
from flatplank_validation.trust import killing as k
from flatplank_validation.trust.registry import Options, Tally, row

NIGHT = 10
"""repetitions of each case"""
BAR = "a step or a run is lost or doubled, a file cannot be read, or a page does not answer"
EFFECTS = ("conicity", "rolling_resistance")


def _waited(programs: list, logs: list[Path]) -> list[str]:
    """What each program said at its end; empty for exit code 0."""
    said = []
    for program, log in zip(programs, logs, strict=True):
        code = program.wait(k.PATIENCE_S)
        lines = log.read_text(errors="replace").splitlines() or [""]
        said.append("" if code == 0 else lines[-1])
    return said


def two_add(top: Path) -> str:
    """Every step that was told as written is in the model, and no other."""
    folder = k.campaign(top / "c")
    logs = [top / f"log{i}" for i in range(2)]
    words = [k.verb("add", effect, folder) for effect in EFFECTS]
    said = _waited([k.started(w, log) for w, log in zip(words, logs, strict=True)], logs)
    kept = {line["effect"] for line in load_model(folder / "model.yaml").history} & {*EFFECTS}
    told = {effect for effect, text in zip(EFFECTS, said, strict=True) if not text}
    if kept != told or not told:
        return f"told as written: {sorted(told)}, kept: {sorted(kept)}; {said}"
    return k.broken(folder)


def two_runners(top: Path) -> str:
    """Two benches measure one plan into one folder: one of them may be refused."""
    plan, folder = top / "killed.yaml", top / "data"
    plan.write_text(k.PLAN, encoding="utf-8")
    logs = [top / f"log{i}" for i in range(2)]
    words = k.verb("run", "--sim", "--jobs", "1", "--data", folder, plan)
    said = _waited([k.started(words, log) for log in logs], logs)
    if all(said):
        return f"both ended with an error: {said}"
    files = [run.info.file for run in Campaign.load(folder).runs]
    if len(files) != k.RUNS:
        return f"{len(files)} runs, {k.RUNS} are right; {said}"
    return k.broken(folder)


def two_panels(top: Path) -> str:
    """Both show their page."""
    return _with_panels(top, 2, lambda folder: k.broken(folder))


def moved_away(top: Path) -> str:
    """The page of a folder that was moved still answers; the folder is whole where it is."""
    return _with_panels(top, 1, lambda folder: k.broken(folder.rename(top / "elsewhere")))


def _with_panels(top: Path, count: int, act: Callable[[Path], str]) -> str:
    """Panels on one folder, before and after something is done to it."""
    folder, token = k.campaign(top / "c"), "of_a_test"
    ports = [k.free_port() for _ in range(count)]
    panels = [
        k.started(
            k.verb("panel", "--port", str(p), "--token", token, "--data", folder,
                   "--log", top / f"bench{p}.log"),
            top / f"log{p}",
        )
        for p in ports
    ]  # fmt: skip

    def asked() -> str:
        found = [k.answers(p, panel, token) for p, panel in zip(ports, panels, strict=True)]
        return "; ".join(text for text in found if text)

    try:
        return asked() or act(folder) or asked()
    finally:
        for panel in panels:
            k.end(panel)


CASES: dict[str, Callable[[Path], str]] = {
    "two add": two_add,
    "two runners": two_runners,
    "two panels": two_panels,
    "folder moved under an open page": moved_away,
}
"""name -> a case in an empty folder"""


@row("together", f"several programs on one folder: {', '.join(CASES)}", BAR)
def together(o: Options) -> Tally:
    """Each case so many times."""
    out, each = Tally(), o.count(NIGHT)
    for name, case in CASES.items():
        for _ in range(each):
            with tempfile.TemporaryDirectory(
                prefix="fp-together-", ignore_cleanup_errors=True
            ) as top:
                failed = case(Path(top))
            out.add(f"{name}: {failed}" if failed else "")
            o.progress(out.many, each * len(CASES))
    return out
