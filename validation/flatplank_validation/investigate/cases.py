# SPDX-License-Identifier: Apache-2.0
"""One loop per case: something of the sealed menu is hidden, and runs are chosen one way or
another; a line of a journal each."""

from __future__ import annotations

import json
import statistics
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from flatplank_analysis.effects.registry import library
from flatplank_analysis.investigation.evidence import ALPHA, Evidence
from flatplank_analysis.investigation.inquiry import questions
from flatplank_analysis.investigation.loop import Loop, Memory
from flatplank_analysis.investigation.notebook import summary
from flatplank_analysis.investigation.planner import DECIDED, SPENT, Choice
from flatplank_analysis.investigation.settings import SLIPS, STARTS, Candidate, Setting
from flatplank_sim.sealed.conditions import LOAD, PRESSURE, STEP
from flatplank_sim.sealed.menu import MENU
from flatplank_validation.blind.journal import code_version, read
from flatplank_validation.blind.points import share
from flatplank_validation.investigate.fast import FastBench

NULL = "nothing"
LIBRARIES = ("menu", "whole")
"""effects that are looked for: those of the sealed menu and what is like them, or all"""


@dataclass(frozen=True)
class Case:
    """One loop to be."""

    hidden: str
    policy: str
    number: int
    effects: str = "menu"

    @property
    def key(self) -> str:
        """Its name in the journal."""
        return f"{self.hidden}/{self.policy}/{self.effects}/{self.number}"


def fixed() -> Candidate:
    """The plan of 27 runs."""
    runs = [Setting(k, s, STEP, LOAD, PRESSURE) for k in SLIPS for s in STARTS]
    return Candidate("27 runs", tuple(runs))


def bench_of(case: Case, seed: int) -> tuple[FastBench, float]:
    """The bench of a case, the same for every policy, and the size of what it hides."""
    draw = crc32(f"{seed}/{case.hidden}/{case.number}".encode())
    hidden = MENU[case.hidden]
    size = hidden.draw(np.random.default_rng(draw))
    few = {n for m in MENU.values() for n in m.names}
    effects = {k: v for k, v in library().items() if case.effects == "whole" or k in few}
    return FastBench(draw, hidden.defects(size), effects), size


def solve(case: Case, seed: int, minutes: float) -> dict[str, Any]:
    """One line of the journal."""
    bench, size = bench_of(case, seed)
    entry = {"key": case.key, "seed": seed, "code": code_version(), "size": size}
    return entry | POLICIES[case.policy](bench, case, minutes) | {"hidden": case.hidden}


def _loop(bench: FastBench, case: Case, minutes: float) -> dict[str, Any]:
    log = Memory()
    Loop(bench, log, minutes).run()
    return _told(summary(log.events))


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

    log = Memory()
    Loop(bench, log, minutes, how=how).run()
    return _told(summary(log.events))


def _fixed(bench: FastBench, case: Case, minutes: float) -> dict[str, Any]:
    plan = fixed()
    price = bench.price(plan)
    order = np.random.default_rng(crc32(case.key.encode())).permutation(len(plan.settings))
    files = bench.make([plan.settings[i] for i in order], 0)
    result = bench.session(files).diagnose()
    return _told(
        {
            "verdict": result.to_dict(), "minutes": price.minutes, "runs": len(files),
            "log_e": 0.0, "ended": "plan made",
        }
    )  # fmt: skip


def _told(s: Mapping[str, Any]) -> dict[str, Any]:
    v = s["verdict"]
    return {
        "verdict": v["verdict"] if v else None, "minutes": round(s["minutes"], 1),
        "runs": s["runs"], "log_e": s["log_e"], "ended": s["ended"],
        "named": [[e["name"], *e["class"]] for e in v["effects"]] if v else [],
    }  # fmt: skip


POLICIES: dict[str, Callable[[FastBench, Case, float], dict[str, Any]]] = {
    "loop": _loop, "random": _random, "fixed": _fixed,
}  # fmt: skip


def right(entry: Mapping[str, Any]) -> bool:
    """What is hidden is in the first class that is named and nothing beside it; or nothing is
    hidden and nothing named."""
    wanted = MENU[entry["hidden"]].names
    if not wanted:
        return not entry["named"]
    return len(entry["named"]) == 1 and wanted[0] in entry["named"][0]


def alarm(entry: Mapping[str, Any]) -> bool:
    """Nothing is hidden, and an effect is named with an e-value of 1/alpha."""
    return bool(entry["named"]) and Evidence(entry["log_e"]).log >= -np.log(ALPHA)


def run(
    cases: Sequence[Case], seed: int, minutes: float, path: Path, say: Callable[[str], None]
) -> list[dict[str, Any]]:
    """What is not in the journal yet is solved; entries of all these cases."""
    path.parent.mkdir(parents=True, exist_ok=True)
    known = of_this_code(path, seed)
    for number, case in enumerate(cases, 1):
        if case.key in known:
            continue
        entry = solve(case, seed, minutes)
        with path.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(entry) + "\n")
        known[case.key] = entry
        say(f"{number}/{len(cases)} {case.key}: {entry['verdict']}, {entry['minutes']:.0f} min")
    return [known[c.key] for c in cases]


def of_this_code(path: Path, seed: int) -> dict[str, dict[str, Any]]:
    """Entries of this seed that the present code of the search made, by key."""
    entries = (e for e in read(path) if (e["seed"], e["code"]) == (seed, code_version()))
    return {e["key"]: e for e in entries}


def lines(entries: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """Shares with Wilson intervals, medians of the minutes."""
    listed = list(entries)
    for policy in POLICIES:
        own = [e for e in listed if e["key"].split("/")[1] == policy]
        some = [e for e in own if e["hidden"] != NULL]
        none = [e for e in own if e["hidden"] == NULL]
        good = [e for e in some if right(e)]
        if some:
            middle = f"{statistics.median(e['minutes'] for e in good):.0f}" if good else "-"
            spent = statistics.median(e["minutes"] for e in some)
            yield (
                f"{policy}: right {share(map(right, some))}; median {middle} min where right, "
                f"{spent:.0f} min of all, {statistics.median(e['runs'] for e in some):g} runs"
            )
        if none:
            yield (
                f"{policy}, nothing hidden: named {share(bool(e['named']) for e in none)}, with "
                f"evidence {share(map(alarm, none))}; "
                f"median {statistics.median(e['minutes'] for e in none):.0f} min"
            )
