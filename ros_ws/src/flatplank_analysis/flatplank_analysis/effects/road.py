# SPDX-License-Identifier: Apache-2.0
"""Speed and surface of the road."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.contact_patch.size import USUAL_HALF, contact_ratio, usual_load_of
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Motion, Tire, TireEffect

BEFORE, AFTER, AFTER_START, AFTER_TURNED_START = 0.1, 0.2, 0.3, 0.6
"""[m] distances of the usual tire before and after a step common to all runs, and after a common
start without and with side slip, within which a patch cannot be told from the transient: two to
three relaxation lengths, of 0.1 m along the wheel and 0.3 m across it"""
COMMON = 0.05
"""[m] largest difference between places that are common to all runs, of the usual tire"""


@dataclass(frozen=True)
class RoadSpeedError(TireEffect):
    """The road is faster or slower than its encoder says: equal slip offset in all runs."""

    identifier = "road_speed_error"
    title = "Mean error of the road speed"
    coordinate = "slip level"
    source = "thesis 6.3: 0.03092 against 0.03096 m/s is -0.13 % of slip"
    what = (
        "A wrong pitch radius or gear in the road encoder gives the same slip offset in all runs."
    )
    check = (
        "Measure the plank travel with a tape or a laser over the whole length; compare with "
        "the encoder. In these runs it cannot be told from the effective rolling radius."
    )
    removes = "The right pinion pitch radius in the parameters."

    error: float = param(
        0.0, unit="1", bounds=(-0.02, 0.02), screen=1e-3, matters=5e-4,
        title="error of the road speed", symbol="ε_V",
        note="Travel of the plank beyond that of its encoder, as a share of it.",
    )  # fmt: skip

    def motion(self, motion: Motion) -> None:
        motion.travel *= 1.0 + self.error


@dataclass(frozen=True)
class SpeedDroop(TireEffect):
    """The plank loses speed in proportion to the longitudinal force, unseen by its encoder."""

    identifier = "speed_droop"
    title = "The plank drive yields to the force"
    coordinate = "slip level"
    source = "thesis table 6.3: about 0.08 % per kN"
    what = (
        "The plank drive gives way under the force. What the encoder on the pinion sees of it "
        "is in the data already; this is what it does not see."
    )
    check = "Second encoder on the plank during a 10 % step."
    removes = "A stiffer speed loop of the plank drive; measured plank position."

    give: float = param(
        0.0, unit="1/N", bounds=(0.0, 4e-6), screen=4e-7, matters=2e-7,
        title="droop", symbol="k_V",
        note="Relative change of the plank speed over the force of the tire.",
    )  # fmt: skip

    def tire(self, tire: Tire) -> None:
        tire.x.give += self.per_run.give


@dataclass(frozen=True)
class Wear(TireEffect):
    """The friction drops from run to run."""

    identifier = "wear"
    title = "Wear of the road surface over the runs"
    coordinate = "run order"
    source = "thesis 3.1: the sandpaper wears during a campaign"
    what = "The sandpaper loses grip during the campaign; runs with much sliding show it."
    check = "Look at the tread."
    shown_by = "The first run once more at the end."
    removes = "New sandpaper; order of the runs at random, so that wear is no trend in the slip."

    loss: float = param(
        0.0, unit="1", bounds=(-0.3, 0.5), screen=0.02, matters=0.01,
        title="loss of friction", symbol="q_w",
        note="Relative loss of friction from the first to the last run.",
    )  # fmt: skip

    def tire(self, tire: Tire) -> None:
        data = tire.data
        share = data.reference.share(data.runs.order, data.reference.first)
        tire.friction *= 1.0 - self.loss * share[:, None]


@dataclass(frozen=True)
class WornPatch(TireEffect):
    """Less friction at one place of the plank, with increasing influence at larger slip."""

    identifier = "worn_patch"
    title = "Worn patch of the road surface"
    coordinate = "plank position"
    source = "thesis 3.1: worn sandpaper at 0.15, 2.35 and 3.90 m"
    what = "The sandpaper is worn or loose at one place of the plank."
    check = "Look at the place."
    shown_by = "With the step at another position the dip stays on the plank."
    removes = "New sandpaper."
    instances = 3

    depth: float = param(
        0.0, unit="1", bounds=(0.0, 0.7), screen=0.05, matters=0.01,
        title="depth", symbol="q_p",
        note="Largest relative loss of friction; of a patch shorter than the contact only this "
             "is seen, not the loss of the paper itself.",
    )  # fmt: skip
    position: float = param(
        2.0, unit="m", bounds=(0.0, 4.2),
        title="place", symbol="x_p", note="Plank position of the middle of the patch.",
    )  # fmt: skip
    width: float = param(
        0.2, unit="m", bounds=(0.03, 0.8),
        title="length", symbol="l_p", note="Length of the patch along the plank.",
    )  # fmt: skip
    blur: float = param(
        0.04, unit="m", bounds=(0.005, 0.1),
        title="length of an edge", symbol="l_e",
        note="Half the length over which an edge comes in: that of the contact, or sharper.",
    )  # fmt: skip

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        """Places over the plank, a contact apart, without those of transients that all runs have:
        patches of a contact and a half."""
        last = float(runs.coordinates["plank position"].values.max())
        width = 1.5 * _contact_of(runs)
        places = np.arange(width, last, _contact_of(runs))
        each = ({"position": float(p), "width": width} for p in places)
        return [one for one in each if cls.separable(runs, one)]

    @classmethod
    def separable(cls, runs: RunSet, values: Mapping[str, float] | None = None) -> bool:
        if values is None:
            return True
        zones = _transients(runs)
        return not any(low <= values["position"] <= high for low, high in zones)

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        """Number of places that a contact tells apart."""
        place = next(p for p in cls.parameters() if p.name == "position")
        return max(round((place.upper - place.lower) / _contact_of(runs)), 1)

    def tire(self, tire: Tire) -> None:
        away = tire.data.position - self.position
        half = 0.5 * self.width
        cover = _edge((away + half) / self.blur) - _edge((away - half) / self.blur)
        most = _edge(half / self.blur) - _edge(-half / self.blur)
        tire.friction *= 1.0 - self.depth * cover / most


def _contact_of(runs: RunSet) -> float:
    """Contact length at the usual load [m]."""
    return 2.0 * USUAL_HALF * contact_ratio(usual_load_of(runs))


def _transients(runs: RunSet) -> list[tuple[float, float]]:
    """Stretches of the plank where all runs have a transient of the tire [m]."""
    size = contact_ratio(usual_load_of(runs))
    steps = runs.facts.get("step", np.array([np.nan]))
    steps = steps[np.isfinite(steps)]
    out = []
    if len(steps) and np.ptp(steps) < COMMON * size:
        step = float(np.median(steps))
        out.append((step - BEFORE * size, step + AFTER * size))
    starts = runs.coordinates["plank position"].values[:, 0]
    if np.ptp(starts) < COMMON * size:
        turned = np.any(runs.facts.get("alpha", np.zeros(1)) != 0.0)
        end = np.median(starts) + size * (AFTER_TURNED_START if turned else AFTER_START)
        # a straight wheel shows a patch from its first slip on
        out.append((-np.inf, float(end if turned else min(end, *steps, np.inf))))
    return out


def _edge(u: np.ndarray) -> np.ndarray:
    """Share of a parabolic contact pressure beyond an edge, u = -1 .. 1."""
    u = np.clip(u, -1.0, 1.0)
    return 0.5 + 0.75 * u - 0.25 * u**3
