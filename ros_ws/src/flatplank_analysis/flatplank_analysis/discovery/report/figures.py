# SPDX-License-Identifier: Apache-2.0
"""Figures of a diagnosis; each function draws on a new figure and returns it."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from flatplank_analysis.discovery import screen
from flatplank_analysis.discovery.report.collapse import collapse_of
from flatplank_analysis.discovery.report.text import channel_of
from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_analysis.discovery.sources import source_of
from flatplank_analysis.discovery.steps import Search, Step
from flatplank_analysis.discovery.where import Map
from flatplank_data.wording import axis_of, probability_words, with_unit

BLUE, ORANGE, GREY, GREEN = "#2b6cb0", "#c05621", "#718096", "#2f855a"
BEFORE: Mapping[str, Any] = {"color": "#d55e00", "ls": (0, (4, 1.5))}
AFTER: Mapping[str, Any] = {"color": "#12406e", "ls": "-"}
"""lines before and after a change: they differ in hue, for the colour-blind too, in lightness, for
print and dark pages, and in dashes"""
COLORS = {"machine": BLUE, "sensor": GREEN, "tire": ORANGE}


class NotebookFigure(Figure):
    """A figure that a notebook displays; matplotlib's own is displayed only by pyplot."""

    def _repr_png_(self) -> bytes:
        return png(self)


def png(figure: Figure) -> bytes:
    stream = io.BytesIO()
    FigureCanvasAgg(figure).print_png(stream)
    return stream.getvalue()


def figure_of(width: float, height: float) -> Figure:
    """A new figure of this size [inch]."""
    return NotebookFigure(figsize=(width, height), layout="constrained", dpi=110)


def clean(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=8)


def labelled(runs: RunSet, text: str) -> str:
    """Axis label of a quantity in the unit of the first channel, whose name is put in."""
    return with_unit(text.format(channel_of(runs)), runs.unit_of())


def short_names(runs: RunSet) -> list[str]:
    """Names of the conditions: the first part, and those parts that not all conditions have."""
    parts = [name.split(", ") for name in runs.condition_names]
    common = set(parts[0]).intersection(*parts)
    return [", ".join([p[0], *(part for part in p[1:] if part not in common)]) for p in parts]


def conditions(steps: Sequence[Step]) -> Figure:
    """Error of every condition at the first and the last step, with the floor."""
    first, last = steps[0], steps[-1]
    runs = last.state.runs
    before = first.state.floors[0].rmse_condition
    after = last.state.floors[0].rmse_condition
    x = np.arange(len(before))
    figure = figure_of(8.0, 3.4)
    axes = figure.add_subplot()
    moved = len(steps) > 1
    alone = "with its effects" if first.state.fit.terms else "base alone"
    width = 0.4 if moved else 0.7
    axes.bar(x - (0.2 if moved else 0), before, width, color=GREY, label=alone)
    if moved:
        axes.bar(x + 0.2, after, width, color=BLUE, label="with the effects")
    floors = last.state.floors[0]
    of_all, by = runs.amount(floors.floor), source_of(runs).words()
    name = f"floor of the condition (of all {of_all}; {by})"
    axes.hlines(floors.by_condition, x - 0.45, x + 0.45, color=ORANGE, lw=2.0, label=name)
    for at, value, error in zip(x, floors.multiples, after, strict=True):
        axes.annotate(
            f"{value:.1f}", (at, error), (0, 2), textcoords="offset points",
            ha="center", fontsize=7,
        )  # fmt: skip
    axes.set_xticks(x, short_names(runs), rotation=30 if len(x) > 9 else 0, fontsize=8)
    axes.set_ylabel(labelled(runs, "RMSE of {}"), fontsize=9)
    figure.legend(fontsize=8, frameon=False, ncols=3, loc="outside upper center")
    clean(axes)
    return figure


def before_and_after(search: Search) -> Figure:
    """The run that gains most: measured, model before and after, and below what each leaves."""
    first, last = search.steps[0].state, search.last.state
    runs = last.runs
    left = [first.residual[0], last.residual[0]]
    r = int(np.argmax(np.sum(left[0] ** 2 - left[1] ** 2, axis=1)))
    name, coordinate = place_of(runs)
    place, floor = coordinate.values[r], last.floors[0].by_condition[runs.condition[r]]
    factor, label = axis_of(name, coordinate.unit, place[[0, -1]])
    place = factor * place
    figure, curves, rest = with_rest(runs, runs.condition_names[runs.condition[r]], label)
    curves.plot(place, runs.measured[0, r], color=GREY, alpha=0.5, lw=3.0, label="measured")
    show_floor(rest, floor, "floor of the condition")
    told = "with its effects" if first.fit.terms else "base alone"
    for residual, style, which in (
        (left[0], BEFORE, told),
        (left[1], AFTER, "with what was found"),
    ):
        error = runs.amount(float(np.sqrt(np.mean(residual[r] ** 2))))
        curves.plot(place, runs.measured[0, r] - residual[r], **style, lw=1.4, label=which)
        rest.plot(place, residual[r], **style, lw=0.9, label=f"{which}: {error}")
    legends_beside(curves, rest)
    return figure


def with_rest(runs: RunSet, title: str, place: str) -> tuple[Figure, Axes, Axes]:
    """A figure of curves of the first channel over a place, and of what a model leaves below."""
    figure = figure_of(8.0, 4.6)
    curves, rest = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    curves.set_title(title, fontsize=9, loc="left")
    curves.set_ylabel(labelled(runs, "{}"), fontsize=9)
    rest.set_ylabel(labelled(runs, "measured - model"), fontsize=9)
    rest.set_xlabel(place, fontsize=9)
    for axes in (curves, rest):
        clean(axes)
    return figure, curves, rest


def show_floor(axes: Axes, floor: float, label: str) -> None:
    """A band between minus and plus the floor."""
    axes.axhspan(-floor, floor, color=GREY, alpha=0.25, lw=0.0, label=label)


def legends_beside(*panels: Axes) -> None:
    for axes in panels:
        axes.legend(fontsize=8, frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))


def place_of(runs: RunSet) -> tuple[str, Coordinate]:
    """The first place coordinate, or else the first coordinate."""
    known = runs.coordinates
    name = next((k for k, c in known.items() if c.local), next(iter(known)))
    return name, known[name]


def map_of(table: Map, runs: RunSet) -> Figure:
    """Mean residual of every condition over one coordinate."""
    figure = figure_of(8.0, 2.7)
    axes = figure.add_subplot()
    limit = float(np.nanmax(np.abs(table.mean))) or 1.0
    rows = np.arange(len(table.mean) + 1)
    factor, label = axis_of(table.coordinate, table.unit, table.edges[[0, -1]])
    mesh = axes.pcolormesh(
        factor * table.edges,
        rows,
        np.ma.masked_invalid(table.mean),
        cmap="RdBu_r",
        vmin=-limit,
        vmax=limit,
    )
    axes.set_yticks(rows[:-1] + 0.5, short_names(runs), fontsize=7)
    axes.set_xlabel(label, fontsize=9)
    figure.colorbar(mesh, ax=axes, label=labelled(runs, "measured - model"), pad=0.01)
    clean(axes)
    return figure


def ranking(search: Search, count: int = 12) -> Figure:
    """Screened gain of the best effects beside the base, and their probabilities at the end."""
    items = screen.best_per_effect(search.steps[0].screen)[:count][::-1]
    stated = search.stated.get("effects", {})
    named = {n for f in search.last.found for n in (f.decision.term.effect.identifier, *f.alike)}
    figure = figure_of(8.0, 0.9 + 0.27 * len(items))
    axes = figure.add_subplot()
    for i, item in enumerate(items):
        name, gain = item.identifier, max(item.gain, 1.0)
        color = COLORS[item.candidate.effect.kind]
        axes.barh(i, gain, color=color, alpha=1.0 if name in named else 0.35)
        text = probability_words(stated[name]) if name in stated else ""
        if not text and screen.negligible(item):
            text = "of no consequence"
        axes.text(gain * 1.1, i, text, va="center", fontsize=7, color=GREY)
    axes.set_xscale("log")
    axes.set_yticks(range(len(items)), [i.identifier for i in items], fontsize=8)
    axes.set_xlim(1.0, axes.get_xlim()[1] * 30.0)
    axes.set_xlabel("drop of the whitened chi2 beside the base (log)", fontsize=9)
    clean(axes)
    return figure


def collapse(search: Search, number: int) -> Figure:
    """Residual of the model without one effect over the effect's coordinate, and the effect."""
    runs, data = search.model.runs, collapse_of(search, number)
    figure = figure_of(8.0, 3.2)
    axes = figure.add_subplot()
    names = short_names(runs)
    shown = data.places[np.abs(data.part) > 0.03 * np.abs(data.part).max()]
    low, high = np.quantile(shown if len(shown) else data.places, (0.002, 0.998))
    low, high = low - 0.3 * (high - low), high + 0.3 * (high - low)
    factor, axis = axis_of(data.coordinate, data.unit, (low, high))
    for i, rows in data.groups:
        color = f"C{i % 10}"
        for k, r in enumerate(rows):
            at = data.every(r, 300)
            x, label = factor * data.places[r][at], names[i] if k == 0 else None
            axes.plot(x, data.left[r][at], ".", ms=1.5, color=color, alpha=0.5,
                      rasterized=True)  # fmt: skip
            axes.plot(x, data.part[r][at], "-", lw=0.9, color=color, label=label)
    axes.set_xlim(factor * low, factor * high)
    axes.set_xlabel(axis, fontsize=9)
    axes.set_ylabel(labelled(runs, "{}: left without it (dots), effect (line)"), fontsize=8)
    figure.legend(fontsize=7, frameon=False, ncols=9, loc="outside upper center")
    clean(axes)
    return figure


def waterfall(steps: Sequence[Mapping[str, Any]], floor: float, runs: RunSet) -> Figure:
    """Fitted and held-out error after every step, with the floor."""
    figure = figure_of(8.0, 3.0)
    axes = figure.add_subplot()
    x = np.arange(len(steps))
    axes.bar(x - 0.18, [s["rmse"] for s in steps], 0.36, color=BLUE, label="fitted")
    held = [s.get("held_out") or s["rmse"] for s in steps]
    axes.bar(x + 0.18, held, 0.36, color=GREY, label="held-out conditions")
    axes.axhline(floor, color=ORANGE, lw=1.5, label="floor")
    axes.set_xticks(x, [s["name"] for s in steps], fontsize=8)
    axes.set_ylabel(labelled(runs, "RMSE of {}"), fontsize=9)
    figure.legend(fontsize=8, frameon=False, ncols=3, loc="outside upper center")
    clean(axes)
    return figure


def residual(step: Step) -> Figure:
    """Mean residual of every condition over the first place coordinate, for inspection only."""
    runs = step.state.runs
    mean = runs.mean(step.state.residual[0])
    name, coordinate = place_of(runs)
    floor = step.state.floors[0].floor
    figure = figure_of(8.0, 0.8 + 0.42 * len(mean))
    axes = figure.add_subplot()
    gap = max(4.0 * floor, 1.2 * float(np.abs(mean).max()))
    factor, place = axis_of(name, coordinate.unit, coordinate.values[0][[0, -1]])
    for i, rows in enumerate(runs.groups):
        axes.axhline(-i * gap, color="#cbd5e0", lw=0.6)
        axes.plot(factor * coordinate.values[rows[0]], mean[i] - i * gap, lw=0.8, color=BLUE)
    ticks = [-i * gap for i in range(len(mean))]
    axes.set_yticks(ticks, short_names(runs), fontsize=8)
    apart = runs.amount(gap, 0)
    axes.set_xlabel(f"{place}; {apart} between the lines", fontsize=9)
    clean(axes)
    return figure


def steps_of(search: Search) -> list[dict[str, Any]]:
    out = []
    for step in search.steps:
        rmse = search.model.runs.rmse(step.state.residual[0])
        name = "\n".join(f"+ {f.decision.term.effect.identifier}" for f in step.found) or "base"
        out.append({"name": name, "rmse": rmse, "held_out": step.held_out})
    return out
