# SPDX-License-Identifier: Apache-2.0
"""Parameters of the base of the search; those that the campaign cannot determine are left out.

What each means is in `flatplank_analysis.words.BASE`. The functions of the kernel: `saturation` is
the steady force (`shape` is n, `denom` is ns there), `shared` the combined slip. Endings: `_y`
across the wheel plane; `_load`, `_bend`, `_pressure` linear and quadratic dependence on the load,
and on the pressure.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flatplank_analysis.contact_patch.size import USUAL_HALF, USUAL_LOAD, contact_ratio
from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_analysis.discovery.parameters import Parameter

BASE = "contact_patch"
"""name of the base in a model file"""
LEAST_LOAD = 5.0
"""[N] root mean square of the load within a run, at `USUAL_LOAD`, below which it is treated as
constant"""
PROTRACTOR = 2e-3
"""[rad] largest zero error of the steering that a protractor does not show: it can be read to a
tenth of a degree"""

START_ROLLING = 0.3
"""[m] of free rolling before a step that show the rolling speed of the wheel"""
SIDE_SLIP = 5e-3
"""[rad] side slip from which both directions share the friction"""


def moving_load(load: np.ndarray) -> float:
    """Root mean square of the load (runs, samples) about the mean of each run [N]."""
    return float(np.sqrt(np.mean((load - load.mean(axis=1, keepdims=True)) ** 2)))


def along_plank(data: TireRuns) -> float:
    """-1 when the wheel of a steered run rolls with the plank speed, 0 when with its component in
    the wheel plane; the run rolls freely before the step."""
    free = (data.since_step < -0.01) & (data.position > 0.5 * START_ROLLING)
    free &= data.since_step.max() > 0.0
    gone = np.where(free, data.travel, 0.0).sum(axis=1)
    turned = np.where(free, data.turned, 0.0).sum(axis=1) * data.radius
    good = (gone > START_ROLLING) & (np.abs(data.alpha) > SIDE_SLIP)
    if not good.any():
        return 0.0
    short = 1.0 - turned[good] / gone[good]
    lost = 1.0 - np.cos(data.alpha[good])
    return 0.0 if float(short @ lost) > 0.5 * float(lost @ lost) else -1.0


def with_side_slip(data: TireRuns) -> bool:
    """True when some runs have side slip."""
    return bool(np.abs(data.alpha).max() > SIDE_SLIP)


def among_loads(data: TireRuns) -> bool:
    """True when the runs differ in load."""
    return bool(np.ptp(data.nominal) > 0.02 * data.reference.load)


def among_pressures(data: TireRuns) -> bool:
    """True when the runs differ in inflation pressure."""
    return bool(np.ptp(data.pressure) > 0.02)


def laws(data: TireRuns) -> list[tuple[float, ...]]:
    """Slip, side slip, camber and load of each run; a run without a constant slip has the number
    of its condition instead."""
    slip = np.where(np.isnan(data.kappa), 1.0 + data.runs.condition, data.kappa)
    settings = np.stack([slip, data.alpha, data.gamma, data.relative_load], axis=1)
    return [tuple(map(float, one)) for one in np.round(settings, 3)]


def base_parameters(data: TireRuns) -> tuple[Parameter, ...]:
    """Parameters of the base for a campaign, start values in `null`, scales in `screen`."""
    load = data.reference.load
    turned = with_side_slip(data)
    shown = {
        "always": True,
        "load within a run": moving_load(data.load) > LEAST_LOAD * load / USUAL_LOAD,
        "side force": "fy" in data.runs.channels,
        "side slip": turned,
        "load": among_loads(data),
        "three loads": len(set(np.round(data.nominal / load, 1))) > 2,
        "pressure": among_pressures(data),
    }
    most = float(np.abs(data.runs.measured[0]).max())
    known = _parameters(load, turned, along_plank(data) if turned else 0.0, most)
    return tuple(p for need, p in known if shown[need])


def _parameters(
    load: float, turned: bool, along: float = 0.0, most: float = 0.0
) -> list[tuple[str, Parameter]]:
    """All parameters, each with what a campaign must have to determine it.

    load: reference load [N]; turned: True with side slip; along: see `along_plank`; most: largest
    measured Fx [N]: a zero error can be as large (a crosstalk of a channel that is not tared).
    """
    force, length = load / USUAL_LOAD, contact_ratio(load)
    half, stiff = USUAL_HALF * length, force / length
    prior = np.inf if turned else 6.0 * load
    zero = max(most, 300.0 * force)
    # with forces in both directions a row of bristles is the better start
    rounding, order, turn = (0.1, 1.0, 0.8) if turned else (0.5, 0.5, 0.5)
    always = [
        Parameter("stiff", "N", 23.0 * load, 5.0 * load, 80.0 * load, 2.0 * load),
        Parameter("peak", "-", 1.05, 0.3, 2.0, 0.1),
        Parameter("shape", "-", 3.0, 1.3, 12.0, 0.5, prior=2.0),
        Parameter("fall", "1", 0.0, -0.4, 0.6, 0.05, prior=0.2),
        Parameter("round", "-", rounding, -0.3, 1.6, 0.3, prior=0.6),
        # rubber leaves the contact with the wheel (1) or with the plank (0), and no sooner
        Parameter("denom", "-", 1.0, -0.3, 1.0, 0.3),
        Parameter("carcass", "N/m", 2.5e5 * stiff, 4e4 * stiff, 3e6 * stiff, 3e4 * stiff),
        Parameter("half", "m", half, 0.4 * half, 2.0 * half, 0.01 * length, prior=0.2 * half),
        Parameter("tread", "-", 1.0, 0.4, 2.5, 0.2, prior=0.3),
        Parameter("fixed_length", "1", 0.0, 0.0, 1.5, 0.2, prior=0.3),
        Parameter("patch_order", "-", order, 0.02, 1.5, 0.2, prior=0.7),
        Parameter("slip_offset", "1", 0.0, -0.02, 0.02, 1e-3),
        Parameter("fx_offset", "N", -30.0 * force, -300.0 * force, 300.0 * force, 20.0 * force),
        Parameter("fx_zero", "N", 0.0, -zero, zero, 10.0 * force, prior=300.0 * force),
    ]
    # the friction follows all of the load
    load_share = Parameter("load_share", "1", 0.8, 0.0, 1.5, 0.3, prior=0.3)
    # without side slip it shows only in lateral effects, whose size it would take
    stiff_y = Parameter(
        "stiff_y", "N", 18.0 * load, 3.0 * load, 80.0 * load, 2.0 * load, prior=prior,
        known=not turned,
    )  # fmt: skip
    side = [
        stiff_y,
        Parameter("carcass_y", "N/m", 1.5e5 * stiff, 2e4 * stiff, 3e6 * stiff, 3e4 * stiff),
        # 1: the rubber of the side force moves through the contact with the wheel, as with
        # bristles; 0: side force and slip are independent
        Parameter("turn_y", "-", turn, 0.0, 1.0, 0.3, prior=0.5),
        # more is an effect (steering zero, ply steer), which then takes all of it
        Parameter(
            "angle_offset", "rad", 0.0, -PROTRACTOR, PROTRACTOR, 1e-3, prior=1e-3, known=True
        ),
    ]
    at_an_angle = [
        Parameter("other_slip", "1", 1.0, 0.0, 1.5, 0.2, prior=0.5),
        Parameter("turn_share", "1", 0.4, 0.0, 1.0, 0.2, prior=0.3),
        Parameter("turn_rate", "-", 0.1, 0.0, 0.5, 0.05, prior=0.1),
        Parameter("grip_y", "-", 1.0, 0.6, 1.6, 0.05, prior=0.1),
        # which of the two speeds the wheel ran with; no effect may hide in the remainder
        Parameter("slip_turned", "-", along, -3.0, 3.0, 0.1, prior=0.05, known=True),
    ]
    return [
        *(("always", p) for p in always),
        ("load within a run", load_share),
        *(("side force", p) for p in side),
        *(("side slip", p) for p in at_an_angle),
        ("load", Parameter("stiff_load", "1", 0.8, -0.5, 2.0, 0.2)),
        ("load", Parameter("peak_load", "1", 0.0, -0.6, 0.6, 0.05)),
        ("load", Parameter("slip_load", "1", 0.0, -0.02, 0.02, 1e-3)),
        ("three loads", Parameter("slip_bend", "1", 0.0, -0.02, 0.02, 1e-3)),
        ("three loads", Parameter("peak_bend", "1", 0.0, -0.4, 0.4, 0.05, prior=0.1)),
        ("pressure", Parameter("stiff_pressure", "1", 0.0, -2.0, 2.0, 0.1)),
        ("pressure", Parameter("peak_pressure", "1", 0.0, -1.0, 1.0, 0.05)),
        ("pressure", Parameter("slip_pressure", "1", 0.0, -0.02, 0.02, 1e-3)),
    ]


NAMES = tuple(p.name for _, p in _parameters(1.0, turned=False))
"""names of all parameters of the base"""

FORMER = {
    "feel": "load_share", "memory": "patch_order", "combine": "other_slip",
    "swing": "turn_share", "rotate": "turn_rate",
}  # fmt: skip
"""name in older model files -> name of today"""

TIRES: tuple[Mapping[str, float], ...] = (
    {"stiff": 0.5, "peak": 0.75, "carcass": 0.5, "stiff_y": 0.5, "carcass_y": 0.6},
    {"stiff": 1.9, "peak": 1.35, "carcass": 2.5, "stiff_y": 1.9, "carcass_y": 2.5},
    {"stiff": 1.0, "peak": 1.0, "carcass": 4.0, "half": 1.5, "stiff_y": 1.0, "carcass_y": 4.0},
)
"""factors on the start values: a soft tire, a stiff one, one with all compliance in the tread"""


def other_starts(parameters: Sequence[Parameter]) -> tuple[dict[str, float], ...]:
    """Start values by name for each of `TIRES`, within their ranges."""
    return tuple(
        {
            p.name: min(max(p.null * tire[p.name], p.lower), p.upper)
            for p in parameters
            if p.name in tire
        }
        for tire in TIRES
    )
