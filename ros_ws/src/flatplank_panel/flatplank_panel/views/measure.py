# SPDX-License-Identifier: Apache-2.0
"""Recording by hand, whole measurements and campaigns (R1.II, R1.III)."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from flatplank_data.machine import USUAL_RADIUS
from flatplank_panel.next_plan import plans_of
from flatplank_panel.views.page import Page

KINDS = {
    "slip": "slip step", "free_rolling": "free rolling", "unloaded_turn": "three unloaded turns",
}  # fmt: skip
STARTS = {1: "1: 0°", 2: "2: 120°", 3: "3: 240°"}


def build(page: Page) -> None:
    folder = _recording(page)
    _run(page, folder)
    _campaign(page, folder)
    _progress(page)


def _recording(page: Page) -> Any:
    op = page.operator
    with page.card("Recording"):
        with page.row():
            folder = page.text("Folder below the data folder")
            name = page.text("Name", "TOY_manual_1")
        note = page.text("Note").classes("w-full")
        at_once = ui.switch("at once, not from the motion trigger on", value=False)
        with page.row():
            page.button(
                "Start logging",
                lambda: op.record(
                    page.id, name.value, folder.value, note.value, at_once.value, {}
                ),
                strong=True,
            )
            page.button("Stop and save", lambda: op.save_recording(page.id))
            page.button("Discard", lambda: op.discard_recording(page.id))
        page.facts({"run": "Now"})
    return folder


def _run(page: Page, folder: Any) -> None:
    with page.card("One measurement from start to end"):
        with page.row():
            kind = page.select("Measurement", KINDS, "slip")
            start = page.select("Start", STARTS, 1)
        with page.row():
            tire = page.text("Tire", "TOY")
            slip = page.number("Slip", 5.0, "%", 1.0)
        with page.row():
            fz = page.number("Load", 3700.0, "N", 100.0)
            pressure = page.number("Pressure", 2.5, "bar", 0.1)
        with page.row():
            radius = page.number("r_e", USUAL_RADIUS, "m", 0.0001)
            at = page.number("Step at", 1.5, "m", 0.1)
            end = page.number("Ends at", 4.1, "m", 0.1)

        def plan() -> dict[str, Any]:
            numbers = {
                "kappa": float(slip.value or 0.0) / 100.0, "fz": fz.value,
                "pressure": pressure.value, "effective_rolling_radius": radius.value,
                "step_position": at.value, "end_position": end.value,
            }  # fmt: skip
            words = {"measurement": kind.value, "start": start.value, "tire": tire.value}
            return words | {k: float(v) for k, v in numbers.items() if v is not None}

        page.button(
            "Measure", lambda: page.operator.measure(page.id, plan(), folder.value), strong=True
        )


def _campaign(page: Page, folder: Any) -> None:
    op = page.operator
    with page.card("Campaign"):
        with page.row():
            chosen = page.select("Plan", list(plans_of(op.data)), None)
            page.refresh(
                "Look for plans again", lambda: chosen.set_options(list(plans_of(op.data)))
            )

        def begin() -> Any:
            plan = plans_of(op.data).get(chosen.value)
            if plan is None:
                raise ValueError("choose a plan first")
            text = plan.read_text(encoding="utf-8")
            return op.measure(page.id, text, folder.value or plan.stem)

        page.button("Start campaign", begin)


def _progress(page: Page) -> None:
    with page.card("Under way"):
        bar = ui.linear_progress(0.0, show_value=False)
        bar.props("instant-feedback aria-label=Progress")
        step = ui.label("nothing").classes("fp-quiet")
        prompt = ui.label("").classes("fp-prompt")
        with page.row():
            page.button("Done, go on", lambda: page.operator.confirm_prompt(page.id))
            page.button("Stop measurement", lambda: page.operator.cancel_measurement(page.id))

    def refresh() -> None:
        p = page.operator.link.state.progress
        count = f"{p.measurement} of {p.measurements}: " if p.measurements > 1 else ""
        step.set_text((f"{count}{p.step}" if p.active else p.message) or "nothing")
        bar.set_value(round(p.share, 3))
        prompt.set_text(p.prompt)
        prompt.set_visibility(bool(p.prompt))

    ui.timer(0.3, refresh)
