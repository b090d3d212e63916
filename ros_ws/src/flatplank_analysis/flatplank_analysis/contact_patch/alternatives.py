# SPDX-License-Identifier: Apache-2.0
"""The class of an effect that was added to a model, and what changes with each of its members."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from flatplank_analysis.discovery import determined
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.steps import Step
from flatplank_analysis.words import BASE
from flatplank_data.wording import quantity, six_digits


def member(term: Term, numbers: Mapping[str, Any], after: Step, instead: Step) -> dict[str, Any]:
    """One member of the class for programs. instead: the step with it in the place of the effect
    that was added; numbers: errors of that step."""
    placed = instead.state.fit.terms[-1]
    return {
        "name": term.effect.identifier,
        "size": six_digits(placed.size),
        "unit": term.effect.main_parameter().unit,
        "rmse": numbers["rmse"],
        "held_out": numbers["held_out"],
        "changes": list(_changes(after, instead)),
    }


def _changes(after: Step, instead: Step) -> Iterator[dict[str, Any]]:
    """Parameters of the tire whose value with the other effect is outside the interval."""
    state = instead.state
    values = {
        p.name: float(v) for p, v in zip(state.model.parameters, state.fit.base, strict=True)
    }
    for number in determined.numbers_of(after.state):
        low, high = number.interval
        if number.owner or not np.isfinite(low) or low <= values[number.name] <= high:
            continue
        yield {
            "parameter": number.name, "unit": number.unit, "value": six_digits(number.value),
            "instead": six_digits(values[number.name]),
        }  # fmt: skip


def words(members: Sequence[Mapping[str, Any]], force: str = "Fx") -> list[str]:
    """What would change with each member, a line each; force: whose error is told."""
    return [
        f"or {m['name']}: {quantity(m['size'], m['unit'])}, error of {force} {m['rmse']:.1f} N, "
        f"held out {m['held_out']:.1f} N; {_changed(m['changes'])}"
        for m in members
    ]


def _changed(changes: Sequence[Mapping[str, Any]]) -> str:
    if not changes:
        return "no number of the tire would leave its interval"
    parts = (
        f"{_title(c['parameter'])} {quantity(c['instead'], c['unit'])} "
        f"instead of {quantity(c['value'], c['unit'])}"
        for c in changes
    )
    return ", ".join(parts)


def _title(parameter: str) -> str:
    """In words; of a tire file its name."""
    return BASE[parameter].title if parameter in BASE else parameter
