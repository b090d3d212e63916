# SPDX-License-Identifier: Apache-2.0
"""Two searches on the same blind campaigns: paired scores, and the reliability of what they state.

Every campaign that both have diagnosed counts once (McNemar's exact test of the campaigns on which
they differ).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import binomtest

from flatplank_sim.sealed.score import LAW
from flatplank_validation.blind import tables
from flatplank_validation.blind.markdown import table

BINS = 10
"""bins of the stated probability"""
Entries = Sequence[Mapping[str, Any]]


def paired(entries: Entries, others: Iterable[Mapping[str, Any]]) -> str:
    """Page: paired scores by row, and the reliability of both searches on the same campaigns."""
    pairs = _pairs(entries, others)
    if not pairs:
        return "the two journals have no campaign in common"
    ours, theirs = [e for e, _ in pairs], [o for _, o in pairs]
    head = ["what", "both right", "only this", "only the other", "neither", "p"]
    parts = [
        f"{len(pairs)} campaigns that both searches diagnosed",
        table(head, list(_rows(ours, theirs))),
        *(f"{name}: {reliability(own)}" for name, own in
          (("this search", ours), ("the other", theirs))),
        f"time: {_seconds(ours)} s here, {_seconds(theirs)} s there (median)",
    ]  # fmt: skip
    return "\n\n".join(parts)


def of_the_same(entries: Entries, others: Entries) -> dict[str, Mapping[str, Any]]:
    """Diagnosed entries, by key, in which the same is hidden as in others of the same name."""
    return {e["key"]: e for e, _ in _pairs(entries, others)}


def _pairs(entries: Entries, others: Iterable[Mapping[str, Any]]) -> list[tuple[Any, Any]]:
    """Diagnosed entries, each with the other one of the same campaign."""
    known = {(e["seed"], e["key"]): e for e in others}
    return [
        (e, other)
        for e in entries
        if e["diagnosis"] and (other := known.get((e["seed"], e["key"]))) and _same(e, other)
    ]


def _same(entry: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """True where the same is hidden: a kit may make other campaigns of the same name."""
    sizes = [[h["size"] for h in e["answer"]["effects"]] for e in (entry, other)]
    return len(sizes[0]) == len(sizes[1]) and np.allclose(*sizes, rtol=1e-6, atol=0.0)


def _rows(ours: Entries, theirs: Entries) -> Iterator[list[str]]:
    scored = list(zip(tables.scored(ours), tables.scored(theirs), strict=True))
    rows = {key: row for key, row in tables.ROWS.items()} | {"all": ("all", lambda p: True)}
    for name, belongs in rows.values():
        own = [(bool(a["right"]), bool(b["right"])) for a, b in scored if belongs(a)]
        if own:
            counts = [own.count(pair) for pair in
                      ((True, True), (True, False), (False, True), (False, False))]  # fmt: skip
            yield [name, *map(str, counts), f"{mcnemar(counts[1], counts[2]):.2g}"]


def mcnemar(one: int, other: int) -> float:
    """p-value of the hypothesis that two searches are equally often right, from the numbers of
    campaigns on which only one is."""
    return float(binomtest(one, one + other).pvalue) if one + other else 1.0


def claims(entry: Mapping[str, Any]) -> Iterator[tuple[float, bool]]:
    """Stated probabilities of an entry, each with whether the claim is true: of every effect and
    of `nothing`. A search that states none claims what it named with one minus its p-value."""
    diagnosis, answer = entry["diagnosis"], entry["answer"]
    hidden = {h["name"] for h in answer["effects"] if h["size"] >= h["consequence"]}
    true = hidden | set(answer.get("present") or [])
    stated = diagnosis.get("posterior")
    if stated is None:
        for e in diagnosis["effects"]:
            names = (
                {e["name"], *e["class"]} if diagnosis["verdict"] == "found group" else {e["name"]}
            )
            yield 1.0 - e["p_value"], bool(names & true)
        return
    for name, probability in stated["effects"].items():
        if name != LAW:  # neither right nor false, see `score`
            yield probability, name in true
    if not answer.get("outside") and not answer.get("present"):
        yield stated["nothing"], not hidden


def reliability(entries: Entries) -> str:
    """Table: stated probability and share of true claims in bins, and their mean distance."""
    pairs = [pair for e in entries for pair in claims(e)]
    rows, error = [], 0.0
    for i in range(BINS):
        own = [p for p in pairs if min(int(p[0] * BINS), BINS - 1) == i]
        if own:
            said = sum(p for p, _ in own) / len(own)
            true = sum(t for _, t in own) / len(own)
            error += len(own) / len(pairs) * abs(said - true)
            rows.append([f"{i / BINS:g} .. {(i + 1) / BINS:g}", str(len(own)), f"{said:.3f}",
                         f"{true:.3f}"])  # fmt: skip
    head = ["stated", "claims", "mean stated", "share true"]
    shown = error if pairs else math.nan
    return f"expected calibration error {shown:.3f}\n\n{table(head, rows)}"


def _seconds(entries: Entries) -> str:
    times = sorted(e["diagnosis"]["seconds"] for e in entries)
    return f"{times[len(times) // 2]:.0f}"
