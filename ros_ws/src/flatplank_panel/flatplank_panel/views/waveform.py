# SPDX-License-Identifier: Apache-2.0
"""Waveform editor: any registered waveform with its own inputs, and a preview over the road."""

from __future__ import annotations

from typing import Any

import numpy as np
from nicegui import ui

from flatplank_control.sequencer.waveforms import WAVEFORMS
from flatplank_data.machine import USABLE_ROAD, USUAL_RADIUS
from flatplank_data.params import describe
from flatplank_panel.operator import waveform_of
from flatplank_panel.views.page import Page
from flatplank_panel.views.plots import ACTUAL, LINE, SOFT

START = {"kappa": 0.05, "amplitude": 0.03, "wavelength": 1.0, "kappa_1": 0.03, "kappa_2": -0.03}


def preview(
    name: str, values: dict[str, Any], start: float, road: float = USABLE_ROAD
) -> list[list[float]]:
    """Slip [%] over plank position [m]; ValueError when the waveform is refused."""
    wave = waveform_of(name, values)
    x = np.unique(np.concatenate([np.linspace(0.0, road, 421), [start - 1e-6, start]]))
    x = x[x >= 0.0]
    slip = [100.0 * wave.slip(p - start) if p >= start else 0.0 for p in x]
    return [[round(float(p), 4), round(s, 4)] for p, s in zip(x, slip, strict=True)]


def chart_options(data: list[list[float]]) -> dict[str, Any]:
    quiet = {"color": SOFT, "fontSize": 11}
    return {
        "animation": False,
        "grid": {"left": 42, "right": 12, "top": 24, "bottom": 24},
        "title": {
            "text": "slip [%] over road [m]",
            "left": 0,
            "top": 0,
            "textStyle": {"fontSize": 12, "fontWeight": 400, "color": SOFT},
        },
        "xAxis": {
            "type": "value",
            "max": USABLE_ROAD,
            "axisLabel": quiet,
            "splitLine": {"show": False},
        },
        "yAxis": {
            "type": "value",
            "axisLabel": quiet,
            "splitNumber": 3,
            "splitLine": {"lineStyle": {"color": LINE}},
        },
        "series": [
            {
                "type": "line",
                "showSymbol": False,
                "data": data,
                "lineStyle": {"width": 1.6, "color": ACTUAL},
            }
        ],
    }


def build(page: Page) -> None:
    with page.row():
        kind = page.select("Waveform", {n: n.replace("_", " ") for n in WAVEFORMS}, "step")
    with page.row():
        radius = page.number("r_e", USUAL_RADIUS, "m", 0.0001)
        start = page.number("Starts at", 1.5, "m", 0.1)
    inputs = page.row()
    chart = ui.echart(chart_options([])).style("height:150px; width:100%")
    hint = ui.label("").classes("fp-quiet")
    fields: dict[str, Any] = {}

    def values() -> dict[str, Any]:
        return {name: field.value for name, field in fields.items()}

    def redraw() -> None:
        try:
            data = preview(kind.value, values(), float(start.value or 0.0))
        except ValueError as error:
            hint.set_text(str(error))
            data = []
        else:
            hint.set_text("")
        chart.options["series"][0]["data"] = data
        chart.update()

    def rebuild() -> None:
        inputs.clear()
        fields.clear()
        with inputs:
            for info in describe(WAVEFORMS[kind.value]):
                unit = "" if info.unit == "-" else info.unit
                field = page.number(info.name, START.get(info.name, info.default), unit, 0.01)
                fields[info.name] = field.on_value_change(redraw)
        redraw()

    kind.on_value_change(rebuild)
    start.on_value_change(redraw)
    rebuild()
    page.button(
        "Set slip control",
        lambda: page.operator.set_waveform(
            page.id, kind.value, values(), start.value, radius.value
        ),
        strong=True,
    )
