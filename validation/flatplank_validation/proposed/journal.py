# SPDX-License-Identifier: Apache-2.0
"""Runs the campaigns of this kit and writes every result at once, so that it can be stopped and
resumed."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.effects.registry import library
from flatplank_analysis.proposal.propose import propose
from flatplank_validation.blind import journal as blind
from flatplank_validation.blind.detectable import kit_version
from flatplank_validation.proposed.cases import Case, make
from flatplank_validation.proposed.left_out import removed

Progress = Callable[[int, int, str], None]


@lru_cache(maxsize=1)
def versions() -> dict[str, str]:
    """Fingerprints of the proposal code and of this kit, which keep other results apart."""
    own = (Path(__file__).with_name(f"{name}.py") for name in ("cases", "forces", "left_out"))
    code = blind.code_version((*blind.JUDGED, "proposal"))
    return {"code": code, "kit": kit_version(tuple(own))}


def solve(case: Case, seed: int) -> dict[str, Any]:
    """Make a case and propose; returns one line of the journal."""
    entry = {"key": case.key, "seed": seed, **versions(), "commit": blind.commit()}
    entry |= {"case": asdict(case)}
    made = make(case, seed)
    if made is None:
        return entry | {"answer": None, "proposal": None}
    tables, answer = made
    gone = removed(case.name) if case.group == "left_out" else set()
    effects = {n: e for n, e in library().items() if n not in gone}
    found = propose(Session.of_tables(tables, effects)).to_dict()
    found.pop("text", None)
    return entry | {"answer": answer, "proposal": found}


def run(
    cases: Sequence[Case], seed: int, path: Path, until: float, clock: Callable[[], float],
    progress: Progress,
) -> list[dict[str, Any]]:  # fmt: skip
    """Solve the cases that the journal lacks, until the time is over; returns all entries."""
    path.parent.mkdir(parents=True, exist_ok=True)
    known = of_this_code(blind.read(path), seed)
    with path.open("a", encoding="utf-8") as stream:
        for case in cases:
            if case.key in known or clock() > until:
                continue
            known[case.key] = solve(case, seed)
            stream.write(json.dumps(known[case.key]) + "\n")
            stream.flush()
            progress(sum(c.key in known for c in cases), len(cases), case.key)
    return [known[c.key] for c in cases if c.key in known]


def of_this_code(
    entries: Sequence[dict[str, Any]], seed: int, any_code: bool = False
) -> dict[str, dict[str, Any]]:
    """Entries of this seed, code and kit by key; `any_code`: also of other code."""
    here = [e for e in entries if (e["seed"], e["kit"]) == (seed, versions()["kit"])]
    return {e["key"]: e for e in here if any_code or e["code"] == versions()["code"]}
