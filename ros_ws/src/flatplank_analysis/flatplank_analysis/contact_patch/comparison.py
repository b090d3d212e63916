# SPDX-License-Identifier: Apache-2.0
"""Where a fitted model fails: error and noise floor by condition, and maps over coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import invariants, where
from flatplank_analysis.discovery.floor import BELOW, beyond
from flatplank_analysis.discovery.sources import source_of
from flatplank_analysis.discovery.steps import Step
from flatplank_analysis.discovery.where import P_FROM, p_words
from flatplank_data.wording import one_of, quantity, six_digits, span, table

ORDERS = 0.1
"""p-value of a map from which its coordinate does not order the residual"""


def errors(session: Session, step: Step) -> dict[str, Any]:
    """Errors, floors and what is beyond them, of all runs and by condition."""
    runs, level = session.data.runs, step.state.floors[0]
    all_runs = session.numbers(step)
    above = {"beyond": six_digits(float(beyond(session.rmse(step), level.floor)))}
    return all_runs | source_of(runs).to_dict() | above | {"conditions": level.rows(runs)}


def numbers(session: Session, step: Step) -> dict[str, Any]:
    """The JSON of `flatplank compare --json`."""
    runs, level = session.data.runs, step.state.floors[0]
    maps = where.make_maps(runs, step.state.residual[0], level.by_condition)
    return errors(session, step) | {
        "where": [
            {
                "coordinate": m.coordinate,
                "unit": m.unit,
                "range": [round(v, 5) for v in m.place],
                "share": round(m.place_share, 3),
                "ordered": round(m.ordered, 3),
                "p_value": round(m.p_value, 4),
            }
            for m in maps
        ],
        "parameters": {
            p.name: float(f"{v:.6g}")
            for p, v in zip(session.model.parameters, step.state.fit.base, strict=True)
        },
        "at_bound": list(step.state.fit.at_bound),
        "at_end": [*invariants.parameters_at_ends(step.state.fitter, step.state.fit).values()],
        "effects": [term.effect.identifier for term in step.state.fit.terms],
    }


def text_of(data: Mapping[str, Any]) -> str:
    """The text that `flatplank compare` prints, from the result of `numbers`."""
    rows = [("condition", "runs", "error [N]", "floor [N]", "error [floors]", "beyond [N]")]
    rows += [
        (
            c["condition"],
            str(c["runs"]),
            f"{c['rmse']:.1f}",
            f"{c['floor']:.1f}" + ("" if c["own_floor"] else " *"),
            f"{c['floors']:.1f}",
            f"{c['beyond']:.1f}",
        )
        for c in data["conditions"]
    ]
    lines = [table(rows), "", "model: " + " + ".join(["tire", *data["effects"]])]
    lines.append(
        f"all: error {data['rmse']:.1f} N, floor {data['floor']:.1f} N, "
        f"beyond it {data['beyond']:.1f} N"
    )
    lines.append(f"the floor is from {data['floor_from']}")
    if not all(c["own_floor"] for c in data["conditions"]):
        lines.append("* not repeated: the floor of all")
    if any(c["floors"] < 1.0 for c in data["conditions"]):
        lines.append(BELOW)
    if data["beyond"] > 0.0:
        lines += _where(data["where"])
    if data["at_end"]:
        lines += ["at an end of its range (`flatplank explain NAME` says what each is):"]
        lines += [f"  {parameter}" for parameter in data["at_end"]]
    return "\n".join(lines)


def _where(maps: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """The coordinates that order the residual, each with the place of the most of it."""
    ordering = [m for m in maps if m["p_value"] < ORDERS]
    others = [m["coordinate"] for m in maps if m["p_value"] >= ORDERS]
    for m in ordering:
        low, high = m["range"]
        share, place = quantity(m["share"], "1", 2), span(low, high, m["unit"])
        yield (
            f"over the {m['coordinate']}: {share} of what is beyond the floor lies within {place} "
            f"({p_words(m['p_value'])})"
        )
    if others:
        yield f"no more order than chance gives over {one_of(others)} (p above {ORDERS:g})"
    if maps:
        yield P_FROM
