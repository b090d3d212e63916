# SPDX-License-Identifier: Apache-2.0
"""A diagnosis in words, as the command line and a notebook show it."""

from __future__ import annotations

from collections.abc import Iterator

from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_data.wording import brief, quantity, sized

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


def text_of(result: Diagnosis) -> str:
    """The text that `flatplank diagnose` prints."""
    lines = [f"verdict: {result.verdict} ({result.reason})"]
    runs = result.search.model.runs if result.search else None
    if runs is not None:
        lines += _errors(result, runs)
    for found in result.found:
        d = found.decision
        effect, unit = d.term.effect, d.term.effect.main_parameter().unit
        lines += [
            f"{effect.identifier}: {sized(d.term.size, d.interval, unit)}, {effect.kind}, "
            f"p = {d.p_value:.2g}",
            f"  {effect.what}",
            f"  check: {effect.check}",
        ]
        lines += [f"  removed by: {effect.removes}"] if effect.removes else []
        if found.reported:
            lines.append(
                f"  cannot be told apart here: {', '.join(r.name for r in found.reported)}"
            )
        for rival in found.reported:
            other = rival.term.effect
            size = quantity(rival.term.size, other.main_parameter().unit)
            lines += [
                f"  or {rival.name}: {size}",
                f"    check: {other.check}",
                f"    removed by: {other.removes}",
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
    if result.next_run:
        lines.append(f"next run: {result.next_run['what']}")
    lines += [f"note: {note}" for note in result.notes]
    return "\n".join(lines + [f"{result.seconds:.1f} s"])


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
            f", within 5 cm {brief(limits.stretch, 0)}, a longer bump of {brief(limits.bump, 0)}, "
            f"a wave of {amount(runs, limits.wave, 0)}"
        )
    yield (
        f"what counts: a mean rest of more than {with_unit(limits.rest)}{stretch}; "
        f"to be found, an error up to {with_unit(limits.error)}"
    )
