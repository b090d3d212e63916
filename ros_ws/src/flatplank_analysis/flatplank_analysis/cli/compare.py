# SPDX-License-Identifier: Apache-2.0
"""Where a model fails: error beside the noise floor, by condition and over the coordinates."""

from __future__ import annotations

from collections.abc import Sequence

from flatplank_analysis.cli import common, loop
from flatplank_analysis.discovery import invariants, where
from flatplank_analysis.wording import plain, quantity


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank compare DIR [--model FILE] [--json]`; DIR/model.yaml counts when it is there."""
    arguments = loop.loop_parser("compare", __doc__).parse_args(argv)
    return common.guarded("compare", lambda: _run(arguments))


def _run(arguments) -> int:
    session, model = loop.open_to_look(arguments, own=True)
    loop.progress("fit", 0.3)
    step = session.fit(model)
    loop.progress_done()
    data = _data(session, step) | {"effects": [e.name for e in model.effects] if model else []}
    if arguments.json:
        common.print_json(data)
    else:
        print(_text(data))
    return 0


def _data(session, step) -> dict:
    runs, level = session.data.runs, step.state.floors[0]
    maps = where.make_maps(runs, step.state.residual[0], level.floor)
    return session.numbers(step) | {
        "conditions": [
            {
                "condition": name,
                "runs": int(len(rows)),
                "rmse": round(float(level.rmse_condition[i]), 3),
                "unexplained": round(float(level.per_condition[i]), 3),
                "floor": round(level.floor, 3),
            }
            for i, (name, rows) in enumerate(zip(runs.condition_names, runs.groups, strict=True))
        ],
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
        "at_end": invariants.at_ends(step.state.fitter, step.state.fit),
    }


def _text(data: dict) -> str:
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
    lines = [loop.table(rows), "", "model: " + " + ".join(["tire", *data["effects"]])]
    lines.append(
        f"all: error {data['rmse']:.1f} N, floor {data['floor']:.1f} N, "
        f"beyond it {data['unexplained']:.1f} N"
    )
    for m in data["where"][:4] if data["unexplained"] > 0.0 else ():
        low, high = m["range"]
        lines.append(
            f"over {m['coordinate']}: {m['share']:.0%} within {plain(low)} .. "
            + quantity(high, m["unit"])
        )
    if data["at_end"]:
        lines.append("at an end of its range: " + ", ".join(data["at_end"]))
    return "\n".join(lines)
