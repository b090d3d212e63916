# SPDX-License-Identifier: Apache-2.0
"""A diagnosis in words, as the command line and a notebook show it."""

from __future__ import annotations

from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.wording import plain, quantity


def text_of(result: Diagnosis) -> str:
    """The diagnosis in words."""
    lines = [f"verdict: {result.verdict} ({result.reason})"]
    if result.search is not None:
        lines.append(
            f"error of Fx: {result.rmse_before:.1f} N before, {result.rmse_after:.1f} N after, "
            f"floor {result.floor:.1f} N; held out {result.held_out_after:.1f} N"
        )
    if result.limits is not None:
        lines.append(
            f"what counts: a mean rest of more than {result.limits.rest:.1f} N, within 5 cm "
            f"{result.limits.stretch:.0f} N; to be found, an error up to "
            f"{result.limits.error:.1f} N"
        )
    for found in result.found:
        d = found.decision
        effect, unit = d.term.effect, d.term.effect.main_parameter().unit
        low, high = d.interval
        lines += [
            f"{effect.identifier}: {quantity(d.term.size, unit, 4)} "
            f"(90 %: {plain(low, 4)} .. {plain(high, 4)}), {effect.kind}, p = {d.p_value:.2g}",
            f"  {effect.what}",
            f"  check: {effect.check}",
            f"  removed by: {effect.removes}",
        ]
        if found.told:
            lines.append(f"  cannot be told apart here: {', '.join(r.name for r in found.told)}")
        for rival in found.told:
            other = rival.term.effect
            size = quantity(rival.term.size, other.main_parameter().unit, 4)
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
                f"{event.level:.0f} N, in {who}"
            )
    if result.next_run:
        repeats = result.next_run.get("repeats")
        lines.append(
            f"next run: {result.next_run['what']}" + (f", {repeats} x" if repeats else "")
        )
    lines += [f"note: {note}" for note in result.notes]
    return "\n".join(lines + [f"{result.seconds:.1f} s"])
