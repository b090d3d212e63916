# SPDX-License-Identifier: Apache-2.0
"""What an answer of the search does not keep of what always holds, see `invariants`."""

from __future__ import annotations

import re

from bare_numbers import bare_numbers
from flatplank_analysis.discovery import invariants
from flatplank_analysis.discovery.report.text import text_of
from flatplank_analysis.discovery.verdict import Diagnosis
from printed_words import unknown_labels


def broken(result: Diagnosis) -> list[str]:
    """What an answer does not keep, in words; empty when it keeps everything."""
    search = result.search
    if search is None:
        return [] if not result.found else ["something is named without a search"]
    out, last = [], search.last.state
    errors = [s.state.runs.rmse(s.state.residual[0]) for s in search.steps]
    for one, other, e, f in zip(search.steps, search.steps[1:], errors, errors[1:], strict=False):
        grown = len(other.found) > len(one.found)
        if grown and invariants.is_raised(f, e):
            out.append(f"the error rises from {e:.3f} to {f:.3f}")
    if invariants.is_raised(result.rmse_after, result.rmse_before):
        out.append(f"the error rises from {result.rmse_before:.3f} to {result.rmse_after:.3f}")
    if result.verdict.startswith("found"):
        left = invariants.residual_of_consequence(last, True)
        out += [f"{result.verdict}, and {left}"] if left else []
    if result.verdict == "found" and any(f.alike for f in result.found):
        out.append("found, and something could stand in for it")
    if result.verdict.startswith("found") and invariants.far_off(last):
        out.append(f"{result.verdict} on a base that is far off everywhere")
    claims = ("none of these", *(["partly"] if result.source.at_most == "found" else []))
    if result.verdict in claims and not invariants.residual_of_consequence(
        last, bool(result.found)
    ):
        out.append(f"{result.verdict}, and nothing of consequence is left")
    told = " ".join(result.notes)
    ends = {
        n
        for f in (last.fit, last.whitened.fit)
        for n in invariants.parameters_at_ends(last.fitter, f)
    }
    once = {n for n in ends if len(re.findall(rf"(?<![\w.]){re.escape(n)} = ", told)) == 1}
    if search.model.runs.units:
        text = text_of(result)
        for name in search.model.runs.condition_names:  # as their machine names them
            text = text.replace(name, "a condition")
        out += [f"without unit: {n}" for n in bare_numbers(text)]
        own = [e.identifier for e in search.effects]
        out += [f"no word: {label}" for label in unknown_labels(text, own)]
    return out + [f"not told once: {n}" for n in ends - once]
