# SPDX-License-Identifier: Apache-2.0
"""Identifies a parasitic fit (Appendix C): three unloaded turns, one fit per channel."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from flatplank_control.calibration.fits import turning_amplitude
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic
from flatplank_data.machine import COUNTS_PER_TURN
from flatplank_data.readers.bag import arrays_of
from flatplank_hw.hub.appendix_a import gains, wheel_from_volts
from flatplank_hw.hub.identify import identify_fit
from flatplank_hw.hub.params import HubParameters
from flatplank_hw.hub.parasitic import INDEX, ParasiticFit, fit_to_text

TOPIC = "/bus/inputs"
THREE_TURNS = 5.9 * math.pi
"""wheel angle of three turns less the stopping angle [rad]"""


class UnloadedTurns(NamedTuple):
    """Raw samples of turns of the unloaded wheel."""

    angle: np.ndarray
    """angle by the wheel encoder's own counter, shape (n,) [rad]"""
    volts: np.ndarray
    """C1..C6, shape (n, 6) [V]"""


def turn_of(counts: Any, volts: Any) -> UnloadedTurns:
    """Samples from the counter of the wheel encoder and the bridge volts."""
    return UnloadedTurns(
        np.array(counts) * 2.0 * math.pi / COUNTS_PER_TURN, np.array(volts, float)
    )


def turn_of_bag(path: Path) -> UnloadedTurns:
    """Samples from the bag of a run."""
    try:
        found = arrays_of(path, TOPIC, ("wheel_counts", "bridge_volts"))
    except (FlatplankError, OSError) as error:
        raise ValueError(f"{path}: no bag that can be read ({error})") from None
    if not len(found["wheel_counts"]):
        raise ValueError(f"{path}: no {TOPIC} in it; record the unloaded turn with the bench")
    return turn_of(found["wheel_counts"], found["bridge_volts"].reshape(-1, 6))


def identify_turn(
    turn: UnloadedTurns, mounting: str, date: str, path: Path, hub: HubParameters | None = None
) -> dict[str, tuple[float, float]]:
    """Write the fit of a mounting to `path`; returns once-per-turn Fx, Fz [N] without and with it.

    ValueError when the wheel was not turned three times.
    """
    reached = float(np.abs(turn.angle - turn.angle[:1]).max(initial=0.0))
    if reached < THREE_TURNS:
        raise ValueError(
            f"unloaded run: the wheel turned {math.degrees(reached):.0f} deg and 1080 deg are "
            "needed; record it again"
        )
    fit = identify_fit(turn.angle, turn.volts, mounting, date)
    p = hub or HubParameters()
    before, after = amplitudes_per_turn(turn, None, p), amplitudes_per_turn(turn, fit, p)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, fit_to_text(fit))
    return {name: (before[name], after[name]) for name in before}


def amplitudes_per_turn(
    turn: UnloadedTurns, fit: ParasiticFit | None, hub: HubParameters
) -> dict[str, float]:
    """Once-per-turn amplitude of Fx and Fz at the wheel [N], without or with a fit.

    It uses the third turn, which the fit does not use.
    """
    inside = np.abs(turn.angle - turn.angle[0])
    keep = (inside > 4.0 * math.pi) & (inside < THREE_TURNS)
    angle, volts = turn.angle[keep], turn.volts[keep].copy()
    if fit is not None:
        signal: Callable[[float], tuple[float, ...]] = fit.signal()
        volts[:, INDEX] -= np.array([signal(a) for a in angle])
    g = gains(hub)
    forces = np.array([wheel_from_volts(tuple(v), g)[:3] for v in volts])
    sizes = turning_amplitude(angle, forces)
    return {name: float(sizes[k]) for k, name in ((0, "fx"), (2, "fz"))}
