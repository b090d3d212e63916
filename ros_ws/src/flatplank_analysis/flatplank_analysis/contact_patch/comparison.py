# SPDX-License-Identifier: Apache-2.0
"""Where a fitted model fails: error and noise floor by condition, and maps over coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import invariants, where
from flatplank_analysis.discovery.sources import source_of
from flatplank_analysis.discovery.steps import Step
from flatplank_data.wording import span, table


def numbers(session: Session, step: Step) -> dict[str, Any]:
    """The JSON of `flatplank compare --json`."""
    runs, level = session.data.runs, step.state.floors[0]
    maps = where.make_maps(runs, step.state.residual[0], level.floor)
    return (
        session.numbers(step)
        | source_of(runs).to_dict()
        | {
            "conditions": by_condition(session, step),
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
    )


def by_condition(session: Session, step: Step) -> list[dict[str, Any]]:
    """Error, its part above the floor, and the floor [N] of every condition."""
    runs, level = session.data.runs, step.state.floors[0]
    return [
        {
            "condition": name,
            "runs": len(rows),
            "rmse": round(float(level.rmse_condition[i]), 3),
            "unexplained": round(float(level.per_condition[i]), 3),
            "floor": round(level.floor, 3),
        }
        for i, (name, rows) in enumerate(zip(runs.condition_names, runs.groups, strict=True))
    ]


def text_of(data: Mapping[str, Any]) -> str:
    """The text that `flatplank compare` prints, from the result of `numbers`."""
    rows = [("condition", "runs", "error [N]", "floor [N]", "beyond [N]")]
    rows += [
        (
            c["condition"],
            str(c["runs"]),
            f"{c['rmse']:.1f}",
            f"{c['floor']:.1f}",
            f"{c['unexplained']:.1f}",
        )
        for c in data["conditions"]
    ]
    lines = [table(rows), "", "model: " + " + ".join(["tire", *data["effects"]])]
    lines.append(
        f"all: error {data['rmse']:.1f} N, floor {data['floor']:.1f} N, "
        f"beyond it {data['unexplained']:.1f} N"
    )
    lines.append(f"the floor is by {data['floor_from']}")
    for m in data["where"][:4] if data["unexplained"] > 0.0 else ():
        low, high = m["range"]
        where = span(low, high, m["unit"])
        lines.append(f"over {m['coordinate']}: {m['share']:.0%} within {where}")
    if data["at_end"]:
        lines.append("at an end of its range: " + ", ".join(data["at_end"]))
    return "\n".join(lines)
