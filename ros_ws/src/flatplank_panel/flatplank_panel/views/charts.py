# SPDX-License-Identifier: Apache-2.0
"""ECharts options of the pages Runs and Discover."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from flatplank_data.wording import axis_of, plain
from flatplank_panel.views.plots import ACTUAL, AXIS_LINE, REFERENCE, SOFT

COLORS = [
    "#1f5488", "#c25700", "#1f6f43", "#7a3e9d", "#8a5a00",
    "#0f7c86", "#a3315f", "#55616f", "#3f6bd1", "#5b7a1e",
]  # fmt: skip
QUIET = {"color": SOFT, "fontSize": 11}
LEGEND = {"top": 0, "right": 0, "left": 70, "align": "left", "textStyle": QUIET}
DASHES = ("solid", "dashed", "dotted")
"""line styles of the repeats of a condition"""


ROOM = 22
"""height below the axis [px] for the bar that zooms"""
ZOOM = {
    "type": "slider", "filterMode": "none", "height": 14, "bottom": 2, "showDetail": False,
    "showDataShadow": False, "brushSelect": False,
}  # fmt: skip


def short_labels(conditions: Sequence[str]) -> list[str]:
    """Labels of conditions without the parts common to all."""
    parts = [c.split(", ") for c in conditions]
    same = set(parts[0]).intersection(*parts[1:]) if len(parts) > 1 else set()
    return [
        ", ".join(p for p in part if p not in same) or c
        for part, c in zip(parts, conditions, strict=True)
    ]


def _named(name: str, gap: int) -> dict[str, Any]:
    """Axis name beside the axis, since the legend is above the y axis."""
    return {
        "name": name, "nameLocation": "middle", "nameGap": gap, "nameTextStyle": QUIET,
        "axisLabel": QUIET,
    }  # fmt: skip


def _categories(names: Sequence[str]) -> dict[str, Any]:
    return {
        "type": "category", "data": names, "axisLabel": QUIET, "axisTick": {"show": False},
    }  # fmt: skip


def axes(x: str, y: str) -> dict[str, Any]:
    """Two named value axes."""
    of_x = {"splitLine": {"show": False}, "axisLine": {"onZero": False, **AXIS_LINE}}
    of_y = {"axisLine": {"show": False, "onZero": False}, "splitLine": AXIS_LINE}
    return {
        "animation": False,
        "color": COLORS,
        "tooltip": {"trigger": "item", "confine": True},
        "grid": {"left": 70, "right": 16, "top": 34, "bottom": 44},
        "xAxis": {"type": "value", "scale": True, **_named(x, 28), **of_x},
        "yAxis": {
            "type": "value", "scale": True, "nameRotate": 90, "splitNumber": 4, **_named(y, 50),
            **of_y,
        },
    }  # fmt: skip


def line(
    name: str, points: Sequence[Sequence[float]], color: str = "", **style: Any
) -> dict[str, Any]:
    made: dict[str, Any] = {
        "type": "line", "name": name, "data": points, "showSymbol": False, "symbol": "none",
        "lineStyle": {"width": 1.4, **style},
    }  # fmt: skip
    if color:
        made["lineStyle"]["color"] = color
        made["itemStyle"] = {"color": color}
    return made


def overlay(curves: Sequence[Mapping[str, Any]], x: str, y: str) -> dict[str, Any]:
    """Curves of runs: one colour per condition, repeats solid, dashed, dotted; with a single
    condition, one colour and name per run."""
    options = axes(x, y)
    labels = _labels(curves)
    repeats = dict.fromkeys(labels, 0)
    options["series"] = []
    for k, c in enumerate(curves):
        label = c["condition"]
        alone = len(labels) == 1
        name, color = (c["file"], COLORS[k % len(COLORS)]) if alone else labels[label]
        dash = DASHES[repeats[label] % len(DASHES)]
        repeats[label] += 1
        options["series"].append(line(name, c["points"], color, type=dash))
    options["legend"] = {**LEGEND, "type": "scroll"}
    options["dataZoom"] = ZOOM
    options["grid"]["bottom"] += ROOM
    return options


def two_campaigns(
    found: Mapping[str, Any], names: tuple[str, str], x: str, y: str
) -> dict[str, Any]:
    """The curves of two campaigns, one colour per condition, the second campaign dashed; below
    them the differences of their means."""
    quantity, _, unit = y.partition(" [")
    options = axes(x, y)
    labels = _labels([*found["curves"], *found["others"]])
    options["series"] = [
        line(f"{labels[c['condition']][0]}, {name}", c["points"], labels[c["condition"]][1],
             type=dash)
        for name, dash, curves in zip(names, DASHES, (found["curves"], found["others"]),
                                      strict=False)
        for c in curves
    ]  # fmt: skip
    options["legend"] = {**LEGEND, "type": "scroll"}
    rests = [
        line(f"{labels[d['condition']][0]}, {names[1]} minus {names[0]}", d["points"],
             labels[d["condition"]][1])
        for d in found["differences"]
    ]  # fmt: skip
    options["legend"]["data"] = list(dict.fromkeys(s["name"] for s in options["series"]))
    return _with_strip(options, f"Δ{quantity} [{unit}" if unit else f"Δ{quantity}", rests)


def _labels(curves: Sequence[Mapping[str, Any]]) -> dict[str, tuple[str, str]]:
    """Condition -> its short label and its colour."""
    labels = list(dict.fromkeys(c["condition"] for c in curves))
    return {
        label: (short, COLORS[k % len(COLORS)])
        for k, (label, short) in enumerate(zip(labels, short_labels(labels), strict=True))
    }


def _with_strip(
    options: dict[str, Any], title: str, lines: Sequence[dict[str, Any]]
) -> dict[str, Any]:
    """A chart with a strip of other lines below it, over the same abscissa and zoomed with it."""
    above, over, force = options["grid"], options["xAxis"], options["yAxis"]
    options["grid"] = [{**above, "bottom": "44%"}, {**above, "top": "64%"}]
    options["grid"][1]["bottom"] += ROOM
    hidden = {"show": False}
    options["xAxis"] = [{**over, "name": "", "axisLabel": hidden}, {**over, "gridIndex": 1}]
    left = {"gridIndex": 1, "name": title, "splitNumber": 2}
    options["yAxis"] = [force, {**force, **left}]
    options["series"] += [{**rest, "xAxisIndex": 1, "yAxisIndex": 1} for rest in lines]
    options["dataZoom"] = {**ZOOM, "xAxisIndex": [0, 1]}
    return options


def measured_and_model(curve: Mapping[str, Any]) -> dict[str, Any]:
    """Both curves, and below them their difference over the same abscissa."""
    options = axes(curve["over"], "Fx [N]")

    def over_x(values: Sequence[float]) -> list[tuple[float, float]]:
        return list(zip(curve["x"], values, strict=True))

    residual = [m - p for m, p in zip(curve["measured"], curve["model"], strict=True)]
    options["series"] = [
        line("measured", over_x(curve["measured"]), ACTUAL),
        line("model", over_x(curve["model"]), REFERENCE, type="dashed"),
    ]
    options["legend"] = {**LEGEND, "data": ["measured", "model"]}
    return _with_strip(options, "residual [N]", [line("residual", over_x(residual), SOFT)])


def against_floor(conditions: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Error of every condition as a bar, its own floor as a mark across the bar."""
    names = short_labels([c["condition"] for c in conditions])
    options = axes("RMS error of Fx [N]", "")
    options["xAxis"] |= {"min": 0, "scale": False}
    options["yAxis"] = {**_categories(names), "inverse": True, "axisLine": AXIS_LINE}
    options["grid"] = {"left": 8, "right": 60, "top": 26, "bottom": 40, "containLabel": True}
    errors = _bars("error", [c["rmse"] for c in conditions], ACTUAL, 14)
    errors["label"] = {"show": True, "position": "right", **QUIET}
    errors["data"] = [
        {"value": _round(c["rmse"]), "label": {"formatter": f"{c['floors']:.1f} floors"}}
        for c in conditions
    ]
    marks = {
        "type": "scatter", "name": "floor of the condition", "symbol": "rect",
        "symbolSize": [3, 18], "itemStyle": {"color": REFERENCE},
        "data": [[_round(c["floor"]), i] for i, c in enumerate(conditions)],
    }  # fmt: skip
    options["series"] = [errors, marks]
    options["legend"] = LEGEND
    return options


def _bars(name: str, values: Sequence[float], color: str, width: int) -> dict[str, Any]:
    """Bars with a largest width [px]."""
    return {
        "type": "bar", "name": name, "data": [_round(v) for v in values],
        "itemStyle": {"color": color}, "barMaxWidth": width,
    }  # fmt: skip


def _draw_floor(
    bars: dict[str, Any], axis: dict[str, Any], at: dict[str, Any], floor: float, where: str
) -> None:
    """Draw the floor as a labelled line across the chart, within the range of the axis."""
    axis["max"] = None if max(bars["data"]) >= floor else math.ceil(1.2 * floor)
    bars["markLine"] = {
        "silent": True,
        "symbol": "none",
        "data": [at],
        "lineStyle": {"color": REFERENCE, "type": "solid", "width": 1.6},
        "label": {"formatter": f"floor {floor:g} N", "color": REFERENCE, "position": where},
    }


def residual_map(m: Mapping[str, Any], conditions: Sequence[str]) -> dict[str, Any]:
    """Mean residual by condition over a coordinate; blue: the model is too high."""
    edges = m["edges"]
    factor, place = axis_of(m["coordinate"], m["unit"], (edges[0], edges[-1]))
    middles = [plain(0.5 * factor * (a + b)) for a, b in zip(edges, edges[1:], strict=False)]
    cells = [
        [j, i, v] for i, row in enumerate(m["mean"]) for j, v in enumerate(row) if v is not None
    ]
    limit = max((abs(c[2]) for c in cells), default=1.0)
    return {
        "animation": False,
        "tooltip": {"confine": True},
        "grid": {"left": 8, "right": 70, "top": 8, "bottom": 40, "containLabel": True},
        "xAxis": {**_categories(middles), **_named(place, 26)},
        "yAxis": {**_categories(short_labels(list(conditions))), "inverse": True},
        "visualMap": {
            "min": -limit, "max": limit, "calculable": False, "orient": "vertical", "right": 0,
            "top": "middle", "itemHeight": 100, "precision": 0, "text": ["N", ""],
            "inRange": {"color": ["#2a5d94", "#f4f5f7", "#b5482a"]}, "textStyle": QUIET,
        },
        "series": [{"type": "heatmap", "data": cells, "name": "measured minus model [N]"}],
    }  # fmt: skip


def collapse(c: Mapping[str, Any]) -> dict[str, Any]:
    """Residual without the effect over the coordinate of the effect, and the effect."""
    options = axes(c["over"], "Fx [N]")
    options["series"] = []
    names = short_labels([s["condition"] for s in c["series"]])
    for i, (s, name) in enumerate(zip(c["series"], names, strict=True)):
        color = COLORS[i % len(COLORS)]
        dots = {"type": "scatter", "name": name, "data": s["left"], "symbolSize": 2.5}
        dots["itemStyle"] = {"color": color, "opacity": 0.6}
        options["series"] += [dots, line(name, s["effect"], color)]
    options["legend"] = {**LEGEND, "type": "scroll"}
    return options


_PROPOSED = (
    ("free curve", "free", 7, "solid"), ("90 %", "low", 7, "dotted"),
    ("90 %", "high", 7, "dotted"), ("form", "form", 1, "solid"),
)  # fmt: skip


def proposed(drawn: Mapping[str, Any]) -> dict[str, Any]:
    """Free curve with its band, and the fitted form."""
    options = axes(drawn["over"], drawn["unit"])
    options["series"] = [
        line(name, drawn[key], COLORS[tone], type=dash)
        for name, key, tone, dash in _PROPOSED
        if key in drawn
    ]  # fmt: skip
    options["legend"] = LEGEND
    return options


def error_of_loop(entries: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Error of an investigation and its floor over the minutes of the bench."""
    options = axes("bench time [min]", "RMS error of Fx [N]")
    options["xAxis"]["min"] = 0
    options["yAxis"] |= {"min": 0, "scale": False}
    measured = [e for e in entries if e["error"] is not None]
    lines = (
        ("tire alone", "error_alone", COLORS[7], "dotted"),
        ("with what was found", "error", COLORS[0], "solid"),
        ("floor", "floor", COLORS[1], "dashed"),
    )
    options["series"] = [
        line(name, [[e["until"], _round(e[key])] for e in measured], color, type=dash)
        | {"showSymbol": True, "symbol": "circle", "symbolSize": 6}
        for name, key, color, dash in lines
    ]
    options["legend"] = LEGEND
    return options


def evidence_of_loop(entries: Sequence[Mapping[str, Any]], limit: float) -> dict[str, Any]:
    """E-value of an investigation over the minutes, and the limit for a decision."""
    options = axes("bench time [min]", "log10 of the e-value")
    points = [[0.0, 0.0]] + [[e["until"], e["so_far"]] for e in entries if e["so_far"] is not None]
    logs = [[m, round(min(max(v / math.log(10.0), -6.0), 30.0), 2)] for m, v in points]
    enough = round(math.log10(limit), 2)
    options["series"] = [
        line("e-value", logs, COLORS[0], type="solid")
        | {"step": "end", "showSymbol": True, "symbol": "circle", "symbolSize": 6},
        line("enough", [[m, enough] for m, _ in (logs[0], logs[-1])], COLORS[1], type="dashed"),
    ]
    options["legend"] = LEGEND
    return options


def waterfall(history: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Fitted and held-out error after every step, with the floor."""
    steps = [h for h in history if h.get("rmse") is not None]
    names = [_step_name(h) for h in steps]
    options = axes("", "RMS error of Fx [N]")
    options["xAxis"] = {**_categories(names), "axisLine": AXIS_LINE}
    options["xAxis"]["axisLabel"] = {**QUIET, "interval": 0}
    options["yAxis"] |= {"min": 0, "scale": False}
    fitted = _bars("fitted", [h["rmse"] for h in steps], ACTUAL, 34)
    fitted["label"] = {
        "show": True, "position": "insideBottom", "fontSize": 11, "color": "#ffffff",
    }  # fmt: skip
    held_out = [h.get("held_out") or h["rmse"] for h in steps]
    options["series"] = [fitted, _bars("held out", held_out, "#a9b7c6", 34)]
    if steps:
        floor = _round(steps[-1]["floor"])
        _draw_floor(fitted, options["yAxis"], {"yAxis": floor}, floor, "insideEndTop")
    options["legend"] = LEGEND
    return options


def _step_name(h: Mapping[str, Any]) -> str:
    sign = {"add": "+ ", "remove": "− "}.get(str(h.get("action")), "")
    return sign + str(h.get("effect") or "base")


def _round(value: float) -> float:
    return round(float(value), 1)
