# SPDX-License-Identifier: Apache-2.0
"""A diagnosis in words, as the command line and a notebook show it."""

from __future__ import annotations

from collections.abc import Iterator

from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_data.wording import brief, quantity, sized

NAMES = {"fx": "Fx", "fy": "Fy"}
"""display names of channels"""


def text_of(result: Diagnosis) -> str:
    lines = [f"verdict: {result.verdict} ({result.reason})"]
    if result.search is not None:
        lines += _errors(result, result.search.model.runs)
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
    if result.verdict in ("none of these", "partly"):
        for m in result.maps[:3]:
            lines.append(f"left over {m.coordinate}: {m.words()}")
        for event in result.events[:3]:
            who = "; ".join(event.conditions)
            lines.append(
                f"event: {event.coordinate} {event.start:.2f} .. {event.end:.2f}, "
                f"{event.level:.{0 if event.level >= 1.0 else 3}f} {_unit(result)}, in {who}"
            )
    if result.next_run:
        repeats = result.next_run.get("repeats")
        lines.append(
            f"next run: {result.next_run['what']}" + (f", {repeats} x" if repeats else "")
        )
    lines += [f"note: {note}" for note in result.notes]
    return "\n".join(lines + [f"{result.seconds:.1f} s"])


def _errors(result: Diagnosis, runs: RunSet) -> Iterator[str]:
    """Errors of the first channel in its unit, and the sizes of consequence."""
    unit, digits = _unit(result), 1 if result.floor >= 1.0 else 3

    def with_unit(value: float) -> str:
        return f"{brief(value) if result.floor < 0.1 else f'{value:.{digits}f}'} {unit}"

    yield (
        f"error of {NAMES.get(runs.channels[0], runs.channels[0])}: "
        f"{with_unit(result.rmse_before)} before, {with_unit(result.rmse_after)} after, "
        f"floor {with_unit(result.floor)}; held out {with_unit(result.held_out_after)}"
    )
    yield f"the floor is by {result.source.words()}"
    limits = result.limits
    if limits is None:
        return
    along = any(c.local and c.unit == "m" for c in runs.coordinates.values())
    stretch = ""
    if along:
        stretch = (
            f", within 5 cm {limits.stretch:.0f}, a longer bump of {limits.bump:.0f}, a wave of "
            f"{limits.wave:.0f} {unit}"
        )
    yield (
        f"what counts: a mean rest of more than {with_unit(limits.rest)}{stretch}; "
        f"to be found, an error up to {with_unit(limits.error)}"
    )


def _unit(result: Diagnosis) -> str:
    units = result.search.model.runs.units if result.search else ()
    return units[0] if units else "N"
