# SPDX-License-Identifier: Apache-2.0
"""Live plots over time or road displacement: forces, moments, drive (R1.V, R1.IX, N.II)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from nicegui import ui

from flatplank_panel.signals import BY_KEY, DRIVE_PLOTS, FORCE_PLOTS
from flatplank_panel.views.page import Page

INK, SOFT, LINE = "#1c2530", "#55616f", "#e6eaef"
ACTUAL, REFERENCE = "#1f5488", "#c25700"
AXES = {"t": "time [s]", "x": "road displacement [m]"}
WINDOWS = {30: "30 s", 60: "1 min", 180: "3 min", 300: "5 min"}


def grid_options(panels: Sequence[Sequence[str]], columns: int) -> dict[str, Any]:
    """ECharts options: one small plot per panel, the unit in its title."""
    rows = -(-len(panels) // columns)
    wide, high = 100 / columns, 100 / rows
    options: dict[str, Any] = {
        "animation": False,
        "grid": [],
        "xAxis": [],
        "yAxis": [],
        "series": [],
        "title": [],
        # as HTML it would touch the page with every drawing, and Tailwind look through all of it
        "tooltip": {"trigger": "axis", "confine": True, "renderMode": "richText"},
    }
    for i, keys in enumerate(panels):
        left, top = (i % columns) * wide, (i // columns) * high
        options["title"].append(
            {
                "text": f"{BY_KEY[keys[0]].label} [{BY_KEY[keys[0]].unit}]",
                "left": f"{left + 0.5}%",
                "top": f"{top}%",
                "textStyle": {
                    "fontSize": 12.5,
                    "fontWeight": 500,
                    "color": INK,
                    "fontFamily": "Roboto",
                },
            }
        )
        options["grid"].append(
            {
                "left": f"{left + 4.5}%",
                "top": f"{top + 16 / rows}%",
                "width": f"{wide - 6}%",
                "height": f"{high - 32 / rows}%",
                "containLabel": False,
            }
        )
        quiet = {"color": SOFT, "fontSize": 11, "hideOverlap": True}
        options["xAxis"].append(
            {
                "type": "value",
                "gridIndex": i,
                "axisLabel": quiet,
                "splitLine": {"show": False},
                "axisLine": {"onZero": False, "lineStyle": {"color": LINE}},
                "axisTick": {"show": False},
                "scale": True,
            }
        )
        options["yAxis"].append(
            {
                "type": "value",
                "gridIndex": i,
                "axisLabel": quiet,
                "scale": True,
                "splitNumber": 3,
                "axisLine": {"show": False},
                "axisTick": {"show": False},
                "splitLine": {"lineStyle": {"color": LINE}},
            }
        )
        for k, key in enumerate(keys):
            options["series"].append(
                {
                    "type": "line",
                    "name": BY_KEY[key].label,
                    "xAxisIndex": i,
                    "yAxisIndex": i,
                    "showSymbol": False,
                    "data": [],
                    "lineStyle": {
                        "width": 1.4 if k == 0 else 1.2,
                        "type": "solid" if k == 0 else "dashed",
                        "color": ACTUAL if k == 0 else REFERENCE,
                    },
                    "itemStyle": {"color": ACTUAL if k == 0 else REFERENCE},
                }
            )
    return options


def build(page: Page) -> None:
    """Both charts and what they are drawn over."""
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
    chart = ui.echart(grid_options(panels, columns)).style(f"height:{height}px; width:100%")
    ui.run_javascript(f"fp.register({chart.id}, {json.dumps([list(p) for p in panels])})")
