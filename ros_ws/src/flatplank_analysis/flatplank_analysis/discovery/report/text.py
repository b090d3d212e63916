# SPDX-License-Identifier: Apache-2.0
"""A diagnosis in words, as the command line and a notebook show it."""

from __future__ import annotations

from collections.abc import Iterator

from flatplank_analysis.discovery.effect import KINDS
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.discovery.view import Cause, Member
from flatplank_data.wording import behind, brief, probability_words, span

NAMES = {"fx": "Fx", "fy": "Fy"}
"""display names of channels"""


def channel_of(runs: RunSet) -> str:
    """Display name of the first channel."""
    return NAMES.get(runs.channels[0], runs.channels[0])


def text_of(result: Diagnosis, folder: str = "DIR") -> str:
    """The text that `flatplank diagnose` prints; `folder`: of the campaign."""
    lines = [f"verdict: {result.verdict} ({result.reason})"]
    runs = result.search.model.runs if result.search else None
    if runs is not None:
        lines += _errors(result, runs)
    for found, cause in zip(result.found, result.causes(), strict=True):
        lines += [
            f"{cause.name}: {cause.sized}, {KINDS[cause.members[0].kind]}, "
            f"{probability_words(found.decision.probability)}",
            *(f"  {_of(m, cause)}{m.what}" for m in cause.members),
        ]
    if runs is not None and result.verdict in ("none of these", "partly"):
        for m in result.maps[:3]:
            lines.append(f"residual over {m.coordinate}: {m.words()}")
        for event in result.events[:3]:
            place = span(event.start, event.end, runs.coordinates[event.coordinate].unit)
            level, who = runs.amount(event.level, 0), "; ".join(event.conditions)
            lines.append(f"event: {event.coordinate} {place}, {level}, in {who}")
    lines += to_do_lines(result, folder)
    lines += [f"note: {note}" for note in result.notes]
    return "\n".join(lines + [f"{result.seconds:.1f} s"])


def _of(member: Member, cause: Cause) -> str:
    return f"{member.name}: " if len(cause.members) > 1 else ""


def to_do_lines(result: Diagnosis, folder: str = "DIR") -> Iterator[str]:
    """What to do, numbered in its order; nothing where nothing is to be done."""
    known = result.tasks(folder)
    if known:
        yield "to do, in this order:"
    for number, task in enumerate(known, 1):
        first, *rest = task.lines()
        yield f"  {number}. {first}"
        yield from (f"     {line}" for line in rest)


def _errors(result: Diagnosis, runs: RunSet) -> Iterator[str]:
    """Errors of the first channel in its unit, and the sizes of consequence."""
    digits = 1 if result.floor >= 1.0 else 3

    def with_unit(value: float) -> str:
        number = brief(value) if result.floor < 0.1 else f"{value:.{digits}f}"
        return behind(number, runs.unit_of())

    yield (
        f"error of {channel_of(runs)}: "
        f"{with_unit(result.rmse_before)} before, {with_unit(result.rmse_after)} after, "
        f"floor {with_unit(result.floor)}; held out {with_unit(result.held_out_after)}"
    )
    worst = max(result.conditions, key=lambda c: c["floors"])
    yield (
        f"worst condition: {worst['condition']}: {with_unit(worst['rmse'])}, "
        f"{worst['floors']:.1f} times its floor of {with_unit(worst['floor'])}"
    )
    yield f"the floor is from {result.source.words()}"
    limits = result.limits
    if limits is None:
        return
    stretch = ""
    if any(c.local and c.unit == "m" for c in runs.coordinates.values()):
        stretch = (
            f", {runs.amount(limits.stretch, 0)} within 5 cm, {runs.amount(limits.bump, 0)} in a "
            f"longer bump or {runs.amount(limits.wave, 0)} in a wave"
        )
    yield (
        f"of consequence: a residual of {with_unit(limits.rest)} in the mean{stretch}; with what "
        f"was found, an error of {with_unit(limits.error)}"
    )
