# SPDX-License-Identifier: Apache-2.0
"""The log of an investigation as text: question and answer of every batch."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from flatplank_analysis.discovery.view import stored
from flatplank_analysis.investigation.evidence import ALPHA, Evidence, e_value_words
from flatplank_analysis.investigation.loop import (
    ANSWER,
    END,
    batches_of,
    budget,
    decoy_words,
    decoys_so_far,
)

Event = Mapping[str, Any]


def summary(events: Sequence[Event]) -> dict[str, Any]:
    """The JSON of `flatplank investigate --json`."""
    answers = list({e["number"]: e for e in events if e["event"] == ANSWER}.values())
    batches = batches_of(events)
    end = events[-1] if events[-1]["event"] == END else None
    evidence = Evidence.of(answers)
    looked_at, accepted = decoys_so_far(answers)
    return {
        "ended": end["why"] if end else None,
        "reason": end["reason"] if end else "not ended yet",
        "verdict": end["verdict"] if end else None,
        "minutes": round(sum(b["minutes"] for b in batches), 1),
        "budget": budget(events),
        "runs": len(events[0]["files"]) + sum(len(a["files"]) for a in answers),
        "runs_before": len(events[0]["files"]),
        "handed_back": sum(len(a["handed_back"]) for a in answers),
        "e_value": float(f"{evidence.e_value:.4g}"),
        "log_e": round(evidence.log, 4),
        "alpha": ALPHA,
        "decoys": {"looked_at": looked_at, "accepted": accepted},
        "batches": batches,
        "proposal": end.get("proposal") if end else None,
    }


def runs_words(first: int, count: int) -> str:
    """Numbers of the runs of a batch."""
    if count < 2:
        return f"run {first}" if count else "no run"
    return f"runs {first} to {first + count - 1}"


def entries_of(log: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Batches with the minutes at which they began and ended, and their results in words."""
    since, first, evidence = 0.0, log["runs_before"] + 1, Evidence()
    for b in log["batches"]:
        count = len(b["settings"])
        entry = {
            **b,
            "since": since,
            "until": since + b["minutes"],
            "runs": runs_words(first, count),
            "back": [
                f"slip {100 * s['kappa']:+g} %, start {s['start']}"
                for s in b.get("handed_back", ())
                if count
            ],
            "evidence": "",
        }
        since, first = entry["until"], first + count
        if b.get("bet"):
            evidence = evidence.with_batch(b["log_e"], True)
            entry["evidence"] = f"{hypothesis_words(b)}, so far {e_value_words(evidence.log)}"
        if "answer" in b:
            entry["so_far"] = evidence.log
        yield entry


def text_of(events: Sequence[Event]) -> str:
    return "\n".join(_lines(events))


def _lines(events: Sequence[Event]) -> Iterator[str]:
    log = summary(events)
    before = log["runs_before"]
    yield f"begun with {before} runs" if before else "begun without runs"
    for b in entries_of(log):
        yield f"{b['runs']}: {b['what']}, {b['reason']} ({b['minutes']:.0f} min)"
        yield from (f"  handed back: {s}" for s in b["back"])
        yield f"  {b.get('answer', 'under way')}"
        if b["evidence"]:
            yield f"  {b['evidence']}"
    if log["ended"]:
        yield f"end: {log['ended']} ({log['reason']})"
    yield f"{log['runs']} runs, {log['minutes']:.0f} of {log['budget']:.0f} minutes"
    yield f"verdict: {verdict_of(log)}"
    yield (
        f"{decoy_words(log['batches'])} (effects in conditions that are not theirs, tested after "
        "every batch: what passes is a false alarm)"
    )
    if log["proposal"]:
        yield proposal_of(log["proposal"])


def proposal_of(proposal: Mapping[str, Any]) -> str:
    """The proposal for a residual that no library effect explains, in words."""
    file = (
        f"; written to {proposal['file']}, a guess until `flatplank confirm` has seen new runs"
        if "file" in proposal
        else ""
    )
    return f"{proposal['verdict']}: {proposal['reason']}{file}"


def hypothesis_words(batch: Mapping[str, Any]) -> str:
    """Evidence of the new runs for the hypothesis that was fixed before, in words."""
    if batch["log_e"] == 0.0:
        return "no evidence from these: the runs before do not tell what the tire does there"
    return (
        f"for {' + '.join(batch['bet'])} against the tire alone: {e_value_words(batch['log_e'])}"
    )


def verdict_of(log: Mapping[str, Any]) -> str:
    """The found effects, and the evidence of the whole investigation."""
    v = log["verdict"]
    if v is None:
        return "none yet"
    limit = 1.0 / ALPHA
    enough = log["log_e"] >= math.log(limit)
    named = ", ".join(stored(e)["text"]["name"] for e in v["effects"])
    what = f"{v['verdict']}{': ' + named if named else ''} ({v['reason']})"
    if not named:
        return f"{what}; {e_value_words(log['log_e'])} against the tire alone"
    sure = "at least" if enough else "less than"
    return (
        f"{what}; {e_value_words(log['log_e'])} against the tire alone over the whole loop, "
        f"{sure} the e = {limit:.0f} that is asked for"
        + ("" if enough else ": not confirmed by runs that had no part in finding it")
    )
