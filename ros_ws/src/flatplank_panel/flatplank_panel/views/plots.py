# SPDX-License-Identifier: Apache-2.0
"""Live plots over time or road displacement: forces, moments, drive (R1.V, R1.IX, N.II)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from nicegui import ui

from flatplank_panel.signals import BY_KEY, DRIVE_PLOTS, FORCE_PLOTS
from flatplank_panel.views.page import Page

INK, SOFT, LINE = "#1c2530", "#55616f", "#c8d0d8"
"""colours of text, of units, and of lines, which are seen in the dark, too: there charts are
inverted"""
AXIS_LINE = {"lineStyle": {"color": LINE}}
TITLE = {"fontSize": 12.5, "fontWeight": 500, "color": INK, "fontFamily": "Roboto"}
ACTUAL, REFERENCE = "#1f5488", "#c25700"
AXES = {"t": "time [s]", "x": "road displacement [m]"}
NARROW = 520
"""width of a chart [px] up to which its plots stand below each other"""
WINDOWS = {30: "30 s", 60: "1 min", 180: "3 min", 300: "5 min"}


def grid_options(
    panels: Sequence[Sequence[str]], columns: int, left_of: float = 4.5
) -> dict[str, Any]:
    """ECharts options: one small plot per panel, the unit in its title, and room for the numbers
    at its left [% of the chart]."""
    rows = -(-len(panels) // columns)
    wide, high = 100 / columns, 100 / rows
    options: dict[str, Any] = {
        "animation": False,
        # as HTML each drawing would change the page, and Tailwind would scan all of it
        "tooltip": {"trigger": "axis", "confine": True, "renderMode": "richText"},
        **{key: [] for key in ("grid", "xAxis", "yAxis", "series", "title")},
    }
    for i, keys in enumerate(panels):
        left, top = (i % columns) * wide, (i // columns) * high
        title = f"{BY_KEY[keys[0]].label} [{BY_KEY[keys[0]].unit}]"
        options["title"].append(
            {"text": title, "left": f"{left + 0.5}%", "top": f"{top}%", "textStyle": TITLE}
        )
        grid = {"left": left + left_of, "top": top + 16 / rows, "width": wide - left_of - 1.5}
        grid["height"] = high - 32 / rows
        percent = {key: f"{value}%" for key, value in grid.items()}
        options["grid"].append({**percent, "containLabel": False})
        axis = {"type": "value", "gridIndex": i, "scale": True, "axisTick": {"show": False}}
        axis["axisLabel"] = {"color": SOFT, "fontSize": 11, "hideOverlap": True}
        of_x = {"splitLine": {"show": False}, "axisLine": {"onZero": False, **AXIS_LINE}}
        of_y = {"splitNumber": 3, "axisLine": {"show": False}, "splitLine": AXIS_LINE}
        options["xAxis"].append({**axis, **of_x})
        options["yAxis"].append({**axis, **of_y})
        styles = ((1.4, "solid", ACTUAL), (1.2, "dashed", REFERENCE))
        for key, (width, dash, color) in zip(keys, styles, strict=False):
            options["series"].append(
                {
                    "type": "line", "name": BY_KEY[key].label, "xAxisIndex": i, "yAxisIndex": i,
                    "showSymbol": False, "data": [], "itemStyle": {"color": color},
                    "lineStyle": {"width": width, "type": dash, "color": color},
                }
            )  # fmt: skip
    return options


def build(page: Page) -> None:
    """Both charts and the choice of their abscissa."""
    del page
    with ui.column().classes("w-full").style("gap:12px"):
        with ui.column().classes("fp-card w-full"):
            _controls()
            _chart([(key,) for key in FORCE_PLOTS], 3, 380)
        with ui.column().classes("fp-card w-full"):
            ui.label("Wheel drive: actual, and reference dashed").classes("fp-head").props(
                "role=heading aria-level=2"
            )
            _chart(DRIVE_PLOTS, 3, 190)


def _controls() -> None:
    with ui.element("div").classes("fp-row"):
        ui.label("Forces and moments at the contact point").classes("fp-head").props(
            "role=heading aria-level=2"
        )
        ui.space()
        axis = ui.toggle(AXES, value="t").props('dense no-caps unelevated aria-label="Plot over"')
        window = ui.select(WINDOWS, value=60).props('outlined dense aria-label="Length shown"')

    def show() -> None:
        ui.run_javascript(f"fp.show({json.dumps(axis.value)}, {int(window.value)})")

    axis.on_value_change(show)
    window.on_value_change(show)


def _chart(panels: Sequence[Sequence[str]], columns: int, height: int) -> None:
    wide = grid_options(panels, columns)
    forms = [
        {"query": {"maxWidth": NARROW}, **_places(grid_options(panels, 1, 14.0))},
        _places(wide),
    ]
    chart = ui.echart({"baseOption": wide, "media": forms})
    chart.style(f"height:{height}px; width:100%; --panels:{len(panels)}").classes("fp-live")
    names = ", ".join(BY_KEY[keys[0]].label for keys in panels)
    chart.props(f'role=img aria-label="{names}: live plots; their numbers are above"')
    Page.exports(chart)
    ui.run_javascript(f"fp.register({chart.id}, {json.dumps([list(p) for p in panels])})")


def _places(options: dict[str, Any]) -> dict[str, Any]:
    """Where the plots of a chart and their titles are."""
    return {"option": {key: options[key] for key in ("grid", "title")}}
