# SPDX-License-Identifier: Apache-2.0
"""The sweep to measure next: it tells a class apart, permits a stronger verdict, or shows what
these sweeps cannot show."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flatplank_analysis.discovery.sources import FOUND
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.inference.nextrun import NO_RUN, next_run
from flatplank_analysis.inference.searched import Searched
from flatplank_analysis.slip_sweeps.effects import effects
from flatplank_analysis.slip_sweeps.model import SweepModel
from flatplank_analysis.slip_sweeps.runs import CHANNEL

CAMBER, LESS, WARM = np.radians(4.0), 0.8, 20.0
"""further camber [rad]; further pressure, as a share; warmer tread [K]"""
Channels = dict[str, np.ndarray]


def _scaled(name: str, share: float) -> Callable[[Channels], Channels]:
    return lambda of: of | {name: share * of[name]}


def _moved(name: str, by: float) -> Callable[[Channels], Channels]:
    return lambda of: of | {name: of[name] + by}


def _later(of: Channels) -> Channels:
    """Twice as late as the last sweep: time and distance."""
    return of | {n: of[n] + 2.0 * float(np.ptp(of[n])) for n in ("time", "distance") if n in of}


@dataclass(frozen=True)
class Further:
    """A sweep that a bench can make next."""

    what: str
    needs: str
    """channel that it changes"""
    change: Callable[[Channels], Channels]


FURTHER = (
    Further("at half of the load", "fz", _scaled("fz", 0.5)),
    Further("at a camber of 4 deg", "gamma", _moved("gamma", CAMBER)),
    Further("at a pressure lower by a fifth", "pressure", _scaled("pressure", LESS)),
    Further("at half of the speed", "speed", _scaled("speed", 0.5)),
    Further("with the tread 20 K warmer", "temperature", _moved("temperature", WARM)),
    Further("at half of the rate of the slip", "rate", _scaled("rate", 0.5)),
    Further("after twice the time and distance", "time", _later),
)
"""each once more with every condition that is visited first"""
RECORD = {
    "temperature": "the same sweeps with the tread temperature recorded",
    "time": "the same sweeps with times",
    "rate": "the same sweeps with times",
    "distance": "the same sweeps with times and speed",
}
"""channel that no further sweep makes -> what to record"""


@dataclass(frozen=True)
class Planned:
    """Sweeps that can be made, with the model that predicts them."""

    text: str
    settings: dict[str, Any]
    model: SweepModel


def missing_sweep(result: Diagnosis) -> dict[str, Any]:
    """The sweep to measure next as the JSON of a diagnosis has it: `what`, and which names it
    `separates`, or which effects it `shows`; {} when nothing is missing."""
    search = result.search
    if search is None:
        return {}
    told = {}
    if isinstance(search, Searched) and isinstance(search.model, SweepModel):
        told = next_run(search, list(_planned(search.model)))
        if told and told["what"] != NO_RUN:
            return told
    if result.source.at_most != FOUND:
        return {"what": "every condition a second time", "shows": ["the scatter of the bench"]}
    return told or _unseen(search.model.runs.coordinates)


def _unseen(coordinates: Mapping[str, Any]) -> dict[str, Any]:
    """The sweep that opens most effects of the library that these sweeps cannot show."""
    opened: dict[str, list[str]] = {}
    for effect in effects():
        lacking = [name for name in effect.needs if name not in coordinates]
        if len(lacking) == 1:
            opened.setdefault(lacking[0], []).append(effect.identifier)
    if not opened:
        return {}
    name = max(opened, key=lambda n: len(opened[n]))
    what = RECORD.get(name) or f"one sweep {next(f.what for f in FURTHER if f.needs == name)}"
    return {"what": what, "shows": opened[name]}


def _planned(model: SweepModel) -> Iterator[Planned]:
    runs = model.runs
    firsts = np.array([group[0] for group in runs.groups])
    for number, further in enumerate(FURTHER, 1):
        if further.needs not in runs.coordinates and further.needs not in ("gamma", "speed"):
            continue
        of = {k.removeprefix(CHANNEL): v for k, v in runs.facts.items() if k.startswith(CHANNEL)}
        if further.needs not in of:
            continue
        for row in firsts:
            one = runs.subset(np.array([row]))
            changed = further.change({k: v[[row]] for k, v in of.items()})
            new_law = further.needs in ("fz", "gamma")
            law = np.array([-number * 1000 - row]) if new_law else one.facts["law"]
            facts = {f"{CHANNEL}{k}": v for k, v in changed.items()} | {"law": law}
            made = copy(model)
            made.runs, made.laws = replace(one, facts=facts), law.tolist()
            label = runs.condition_names[int(runs.condition[row])]
            text = f"{label}, {further.what}"
            yield Planned(text, {further.needs: float(np.median(changed[further.needs]))}, made)
