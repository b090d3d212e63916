# SPDX-License-Identifier: Apache-2.0
"""Runs one loop per case: a defect of the sealed menu is hidden, and a policy chooses the runs.
Each loop gives one line of a journal."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from flatplank_analysis.effects.registry import library
from flatplank_analysis.investigation.evidence import ALPHA, Evidence
from flatplank_analysis.investigation.inquiry import questions
from flatplank_analysis.investigation.loop import Choose, Loop, MemoryLog, choose_by_questions
from flatplank_analysis.investigation.notebook import summary
from flatplank_analysis.investigation.planner import DECIDED, SPENT, Choice
from flatplank_analysis.investigation.settings import SLIPS, STARTS, Candidate, Setting
from flatplank_sim.sealed.conditions import LOAD, PRESSURE, STEP
from flatplank_sim.sealed.menu import MENU
from flatplank_validation.blind.journal import JUDGED, code_version, commit, read, solved
from flatplank_validation.investigate.fast import FastBench

NULL = "nothing"
LIBRARIES = ("menu", "whole")
"""effects of the search: those of the sealed menu and their relatives, or all"""


@dataclass(frozen=True)
class Case:
    """Definition of one loop."""

    hidden: str
    policy: str
    number: int
    effects: str = "menu"

    @property
    def key(self) -> str:
        """Key in the journal."""
        return f"{self.hidden}/{self.policy}/{self.effects}/{self.number}"


def fixed() -> Candidate:
    """The plan of 27 runs."""
    runs = [Setting(k, s, STEP, LOAD, PRESSURE) for k in SLIPS for s in STARTS]
    return Candidate("27 runs", tuple(runs))


def bench_of(case: Case, seed: int) -> tuple[FastBench, float]:
    """Bench of a case, the same for every policy, and the size of its hidden effect."""
    draw = crc32(f"{seed}/{case.hidden}/{case.number}".encode())
    hidden = MENU[case.hidden]
    size = hidden.draw(np.random.default_rng(draw))
    few = {n for m in MENU.values() for n in m.names}
    effects = {k: v for k, v in library().items() if case.effects == "whole" or k in few}
    return FastBench(draw, hidden.defects(size), effects), size


def solve(case: Case, seed: int, minutes: float) -> dict[str, Any]:
    """Run the loop of a case; returns one line of the journal."""
    bench, size = bench_of(case, seed)
    entry = {"key": case.key, "seed": seed, "code": judged(), "commit": commit(), "size": size}
    return entry | POLICIES[case.policy](bench, case, minutes) | {"hidden": case.hidden}


def judged() -> str:
    """Fingerprint of the code for diagnosis and planning."""
    return code_version((*JUDGED, "investigation"))


def _loop(bench: FastBench, case: Case, minutes: float) -> dict[str, Any]:
    return _made(bench, minutes, choose_by_questions)


def _made(bench: FastBench, minutes: float, how: Choose) -> dict[str, Any]:
    """A whole loop, with the processor time of each choice [s]."""
    log, seconds = MemoryLog(), []

    def timed(*arguments) -> Choice:
        began = time.process_time()
        try:
            return how(*arguments)
        finally:
            seconds.append(round(time.process_time() - began, 1))

    Loop(bench, log, minutes, how=timed).run()
    return _result(summary(log.events)) | {"planning": seconds}


def _random(bench: FastBench, case: Case, minutes: float) -> dict[str, Any]:
    random = np.random.default_rng(crc32(case.key.encode()))

    def how(result, evidence, made, possible, price, left) -> Choice:
        if not [q for q in questions(result, evidence, made) if q.open > 0.0]:
            return Choice(None, "every question is answered", stop=DECIDED)
        fits = [(c, p) for c in possible if (p := price(c)).minutes <= left]
        if not fits:
            return Choice(None, "no run fits", stop=SPENT)
        c, p = fits[int(random.integers(len(fits)))]
        return Choice(c, "at random", p)

    return _made(bench, minutes, how)


def _text(bench: FastBench, case: Case, minutes: float) -> dict[str, Any]:
    """Policy: make the run that the diagnosis names. If it names none that this bench can make,
    take the next three of the plan of 27, until an effect is found or the plan is complete."""
    asked: set[tuple[Setting, ...]] = set()

    def how(result, _evidence, made, _possible, price, left) -> Choice:
        c = named_run(result.next_run) or _next_three(made)
        if result.found and not result.next_run:
            return Choice(None, "the diagnosis asks for no run", stop=DECIDED)
        if c is None or c.settings in asked:
            return Choice(None, "the plan is made", stop=DECIDED)
        if (p := price(c)).minutes > left:
            return Choice(None, "the run that is named takes longer", stop=SPENT)
        asked.add(c.settings)
        return Choice(c, "as the diagnosis says", p)

    return _made(bench, minutes, how)


def named_run(next_run: Mapping[str, Any]) -> Candidate | None:
    """Parse the text `next run` of a diagnosis to runs; None when it names none, or one with
    another speed, a preload, or an unusual start angle."""
    s = next_run.get("settings") or {}
    known = {"kappa", "fz", "pressure", "step_position", "starts"}
    if set(s) != known or not set(s["starts"]) <= set(STARTS):
        return None
    runs = [
        Setting(s["kappa"], start, round(s["step_position"], 3), s["fz"], s["pressure"])
        for start in s["starts"] * next_run["repeats"]
    ]
    return Candidate(next_run["what"], tuple(runs))


def _next_three(made: Sequence[Setting]) -> Candidate | None:
    """Next three runs of the plan of 27, one slip level at a time."""
    there = set(made)
    for kappa in SLIPS:
        lacking = tuple(s for s in fixed().settings if s.kappa == kappa and s not in there)
        if lacking:
            return Candidate(f"slip {100 * kappa:+g} %", lacking)
    return None


def _fixed(bench: FastBench, case: Case, minutes: float) -> dict[str, Any]:
    plan = fixed()
    price = bench.price(plan)
    order = np.random.default_rng(crc32(case.key.encode())).permutation(len(plan.settings))
    files = bench.make([plan.settings[i] for i in order], 0)
    result = bench.session(files).diagnose()
    return _result(
        {
            "verdict": result.to_dict(), "minutes": price.minutes, "runs": len(files),
            "log_e": 0.0, "ended": "plan made",
        }
    )  # fmt: skip


def _result(s: Mapping[str, Any]) -> dict[str, Any]:
    v = s["verdict"]
    decoys = s.get("decoys", {"looked_at": 0, "accepted": []})
    return {
        "decoys": [decoys["looked_at"], len(decoys["accepted"])],
        "verdict": v["verdict"] if v else None, "minutes": round(s["minutes"], 1),
        "runs": s["runs"], "log_e": s["log_e"], "ended": s["ended"],
        "named": [[e["name"], *e["class"]] for e in v["effects"]] if v else [],
    }  # fmt: skip


POLICIES: dict[str, Callable[[FastBench, Case, float], dict[str, Any]]] = {
    "loop": _loop, "fixed": _fixed, "text": _text, "random": _random,
}  # fmt: skip


def right(entry: Mapping[str, Any]) -> bool:
    """True when the hidden effect is in the first named class and no other is named, or when
    nothing is hidden and nothing named."""
    wanted = MENU[entry["hidden"]].names
    if not wanted:
        return not entry["named"]
    return len(entry["named"]) == 1 and wanted[0] in entry["named"][0]


def alarm(entry: Mapping[str, Any]) -> bool:
    """True for a false alarm: nothing is hidden, and an effect is named with an e-value of
    1/alpha."""
    return bool(entry["named"]) and Evidence(entry["log_e"]).log >= -np.log(ALPHA)


def run(
    cases: Sequence[Case],
    seed: int,
    minutes: float,
    path: Path,
    say: Callable[[str], None],
    jobs: int = 1,
) -> list[dict[str, Any]]:
    """Solve the cases that the journal lacks, in processes; returns the entries of all cases."""
    path.parent.mkdir(parents=True, exist_ok=True)
    known = of_this_code(path, seed)
    missing = [c for c in cases if c.key not in known]
    done = len(cases) - len(missing)
    for entry in solved(partial(solve, seed=seed, minutes=minutes), missing, jobs):
        with path.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(entry) + "\n")
        known[entry["key"]] = entry
        done += 1
        told = f"{entry['verdict']}, {entry['minutes']:.0f} min"
        say(f"{done}/{len(cases)} {entry['key']}: {told}")
    return [known[c.key] for c in cases]


def of_this_code(path: Path, seed: int, any_code: bool = False) -> dict[str, dict[str, Any]]:
    """Entries of this seed by the present code, by key; with `any_code` also entries of other code
    where the present has none."""
    entries = [e for e in read(path) if e["seed"] == seed]
    old = {e["key"]: e for e in entries} if any_code else {}
    return old | {e["key"]: e for e in entries if e["code"] == judged()}
