# SPDX-License-Identifier: Apache-2.0
"""The wheel drive: enable, fault, the six operation modes and their inputs (R1.VII to R1.IX)."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from nicegui import ui

from flatplank_control.free_rolling import FreeRollingParameters
from flatplank_data.machine import USABLE_ROAD, USUAL_RADIUS
from flatplank_data.params import parameter_infos
from flatplank_data.waveforms import WAVEFORMS
from flatplank_data.wording import behind, displayed
from flatplank_panel.operator import PREDETERMINED, VALUES, waveform_of
from flatplank_panel.views.page import Page
from flatplank_panel.views.plots import ACTUAL, AXIS_LINE, SOFT

START = {"kappa": 0.05, "amplitude": 0.03, "wavelength": 1.0, "kappa_1": 0.03, "kappa_2": -0.03}
"""start values of the inputs of a waveform"""
FACTS = {"state": "State", "mode": "Mode", "stop": "Held because", "error": "Error"}


def build(page: Page) -> None:
    op = page.operator
    with page.card("Drive"):
        page.facts(FACTS)
        with page.row():
            page.button("Enable", lambda: op.enable(page.id, True), strong=True)
            page.button("Disable", lambda: op.enable(page.id, False))
            page.button("Reset fault", lambda: op.reset_fault(page.id))
            page.button("Quick stop", lambda: op.quick_stop(page.id))
    with page.card("Position"):
        with page.row():
            for angle in PREDETERMINED:
                page.button(f"{angle:g}°", partial(op.move_to, page.id, angle))
        with page.row():
            target = page.number("Angle", 0.0, "deg")
            page.button("Turn there", lambda: op.move_to(page.id, target.value))
            page.button("Home: this is 0°", lambda: op.set_mode(page.id, "homing"))
    with page.card("Longitudinal slip"):
        _waveform(page)
    with page.card("Velocity, torque, free rolling"):
        for mode, start in (("velocity", 0.05), ("torque", 1.0)):
            _value(page, mode, start)
        with page.row():
            page.button("Free rolling", lambda: op.set_mode(page.id, "free_rolling"))
            held = f"{FreeRollingParameters.reference:g} N, thesis 5.5"
            ui.label(f"holds Fx near zero ({held}) while the plank moves").classes("fp-quiet")


def _value(page: Page, mode: str, start: float) -> None:
    what, unit, _, _ = VALUES[mode]
    with page.row():
        field = page.number(what.capitalize(), start, unit)
        page.button(f"Set {what}", lambda: page.operator.set_mode(page.id, mode, field.value))


def preview(name: str, values: dict[str, Any], start: float) -> list[list[float]]:
    """Points of slip [%] over plank position [m]; ValueError when the waveform is refused."""
    wave = waveform_of(name, values)
    x = np.unique(np.concatenate([np.linspace(0.0, USABLE_ROAD, 421), [start - 1e-6, start]]))
    x = x[x >= 0.0]
    slip = [100.0 * wave.slip(p - start) if p >= start else 0.0 for p in x]
    return [[round(float(p), 4), round(s, 4)] for p, s in zip(x, slip, strict=True)]


def in_si(value: Any, factor: float) -> Any:
    """The number of a field in SI; what is no number, as an empty field, stays as it is."""
    return value / factor if isinstance(value, (int, float)) else value


def chart_options(data: list[list[float]]) -> dict[str, Any]:
    axis = {"type": "value", "axisLabel": {"color": SOFT, "fontSize": 11}}
    style = {"fontSize": 12, "fontWeight": 400, "color": SOFT}
    line = {"type": "line", "showSymbol": False, "data": data}
    return {
        "animation": False,
        "grid": {"left": 42, "right": 12, "top": 24, "bottom": 24},
        "title": {"text": "slip [%] over road [m]", "left": 0, "top": 0, "textStyle": style},
        "xAxis": {**axis, "max": USABLE_ROAD, "splitLine": {"show": False}},
        "yAxis": {**axis, "splitNumber": 3, "splitLine": AXIS_LINE},
        "series": [{**line, "lineStyle": {"width": 1.6, "color": ACTUAL}}],
    }


def _waveform(page: Page) -> None:
    with page.row():
        kind = page.select("Waveform", {n: n.replace("_", " ") for n in WAVEFORMS}, "step")
    with page.row():
        radius = page.number("r_e", USUAL_RADIUS, "m", 0.0001)
        start = page.number("Starts at", 1.5, "m", 0.1)
    inputs = page.row()
    chart = ui.echart(chart_options([])).style("height:150px; width:100%")
    hint = ui.label("").classes("fp-quiet")
    fields: dict[str, tuple[Any, float]] = {}
    """parameter -> its field, and the factor from SI to what the field shows"""

    def values() -> dict[str, Any]:
        return {n: in_si(field.value, factor) for n, (field, factor) in fields.items()}

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
            for info in parameter_infos(WAVEFORMS[kind.value]):
                factor, unit = displayed(info.unit)
                shown = factor * START.get(info.name, info.default)
                field = page.number(info.name, shown, behind("", unit).strip(), 0.01 * factor)
                fields[info.name] = field.on_value_change(redraw), factor
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
