# SPDX-License-Identifier: Apache-2.0
"""A diagnosis in words, as the command line and a notebook show it."""

from __future__ import annotations

from collections.abc import Iterator

from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.discovery.view import Cause, Member
from flatplank_data.wording import brief, probability_words

NAMES = {"fx": "Fx", "fy": "Fy"}
"""display names of channels"""


def channel_of(runs: RunSet) -> str:
    """Display name of the first channel."""
    return NAMES.get(runs.channels[0], runs.channels[0])


def unit_of(runs: RunSet) -> str:
    """Unit of the first channel; empty where the runs have none."""
    return runs.units[0] if runs.units else ""


def amount(runs: RunSet, value: float, digits: int = 1) -> str:
    """A value of the first channel with its unit."""
    return f"{brief(value, digits)} {unit_of(runs)}".rstrip()


def text_of(result: Diagnosis, folder: str = "DIR") -> str:
    """The text that `flatplank diagnose` prints; `folder`: of the campaign."""
    lines = [f"verdict: {result.verdict} ({result.reason})"]
    runs = result.search.model.runs if result.search else None
    if runs is not None:
        lines += _errors(result, runs)
    for found, cause in zip(result.found, result.causes(), strict=True):
        lines += [
            f"{cause.name}: {cause.sized}, {cause.members[0].kind}, "
            f"{probability_words(found.decision.probability)}",
            *(f"  {_of(m, cause)}{m.what}" for m in cause.members),
        ]
    if runs is not None and result.verdict in ("none of these", "partly"):
        for m in result.maps[:3]:
            lines.append(f"left over {m.coordinate}: {m.words()}")
        for event in result.events[:3]:
            who = "; ".join(event.conditions)
            lines.append(
                f"event: {event.coordinate} {event.start:.2f} .. {event.end:.2f}, "
                f"{amount(runs, event.level, 0)}, in {who}"
            )
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
        return f"{number} {unit_of(runs)}".rstrip()

    yield (
        f"error of {channel_of(runs)}: "
        f"{with_unit(result.rmse_before)} before, {with_unit(result.rmse_after)} after, "
        f"floor {with_unit(result.floor)}; held out {with_unit(result.held_out_after)}"
    )
    worst = max(result.conditions, key=lambda c: c["floors"])
    yield (
        f"worst of its own floor: {worst['condition']}, {with_unit(worst['rmse'])}, "
        f"{worst['floors']:.1f} floors of {with_unit(worst['floor'])}"
    )
    yield f"the floor is by {result.source.words()}"
    limits = result.limits
    if limits is None:
        return
    along = any(c.local and c.unit == "m" for c in runs.coordinates.values())
    stretch = ""
    if along:
        stretch = (
            f", within 5 cm {amount(runs, limits.stretch, 0)}, a longer bump of "
            f"{amount(runs, limits.bump, 0)}, a wave of {amount(runs, limits.wave, 0)}"
        )
    yield (
        f"what counts: a mean rest of more than {with_unit(limits.rest)}{stretch}; "
        f"to be found, an error up to {with_unit(limits.error)}"
    )
