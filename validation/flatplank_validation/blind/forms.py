# SPDX-License-Identifier: Apache-2.0
"""Campaigns of the second tire on a machine whose faults have other forms (forms_kernel.py).

Machine and sensors were written independently of the library of effects. To first order the sizes
mean the same as in the menu: a gap is the travel from stop to stop, a drift its final value, a
wave its first harmonic.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.random import Generator as Random

from flatplank_sim.sealed.conditions import LOAD, PRESSURE, Columns, Run
from flatplank_validation.blind.forms_kernel import FORM_AT, FORMS, run_forms
from flatplank_validation.blind.second import (
    ROAD_CELLS,
    SAMPLES,
    SecondMachine,
    SecondTire,
    late,
    numbers_of,
)
from flatplank_validation.blind.second_kernel import AT, OUT, SAMPLE

LEVELS = {"fx": 2500.0, "fy": 1500.0, "fz": 120.0, "mx": 8.0, "mz": 12.0}
"""level of a channel at which its crosstalk saturates [N, N m]"""
BEND = 3.0
"""number of time constants over all runs, for changes that saturate"""


@dataclass(frozen=True)
class FormsMachine:
    """Faults of the machine: parameters of the kernel by name, and faults of the sensors."""

    kernel: Mapping[str, float] = field(default_factory=dict)
    load_power: float = 0.0
    """exponent of the carcass stiffness over load"""
    pressure_share: float = 0.0
    """change of the carcass stiffness per relative change of pressure; it saturates"""
    wear: float = 0.0
    """grip lost from the first to the last run, most of it in the first third"""
    patch: tuple[float, float, float] | None = None
    """(centre [m], width [m], loss of grip), with a smooth profile"""
    parasitic: float = 0.0
    """force of a shaft that rubs on one side [N]: in Fx, and 0.8 of it in Fz"""
    uneven: float = 0.0
    """once-per-turn force in Fx with a sharp peak [N]"""
    mix: Mapping[tuple[str, str], float] = field(default_factory=dict)
    """(source, target) -> crosstalk for a small change of the source"""
    drift: float = 0.0
    """mean drift of Fx over a run, with falling slope [N/s]"""
    drift_runs: float = 0.0
    """change of Fx from the first to the last run, with falling slope [N]"""
    lag: float = 0.0
    """total lag of two equal filters [s]"""
    skew: float = 0.0
    """time skew in the middle of a run [s]; it changes by 10 % towards either end"""
    rolling_share: float = 0.0
    load_waves: float = 0.0
    """additional load undulation over the plank, which the hub measures [N]"""


def fading(share: np.ndarray | float, bend: float = BEND) -> Any:
    """Saturating curve from 0 to 1."""
    return np.expm1(-bend * share) / math.expm1(-bend)


def measure(
    tire: SecondTire,
    machine: FormsMachine,
    run: Run,
    count: int,
    gain: float,
    delay: float,
    bumps: np.ndarray,
) -> Columns:
    """Make one run without noise; the campaign has `count` runs."""
    share, s = run.index / max(count - 1, 1), run.setting
    friction = np.full(ROAD_CELLS, 1.0 - machine.wear * fading(share))
    if machine.patch:
        middle, width, loss = machine.patch
        u = (np.arange(ROAD_CELLS) / 500.0 - middle) / width
        friction *= 1.0 - loss * np.exp(-4.0 * u**4)
    numbers = numbers_of(tire, SecondMachine(), run, gain, delay)
    over = machine.pressure_share * 0.5 * math.tanh((s.pressure / PRESSURE - 1.0) / 0.5)
    soft = (s.fz / LOAD) ** machine.load_power * (1.0 + over)
    for name in ("carcass_x", "carcass_y"):
        numbers[AT[name]] *= soft
    form = np.zeros(len(FORMS))
    form[FORM_AT["ripple_period"]] = form[FORM_AT["wave_period"]] = 0.7
    for name, value in machine.kernel.items():
        form[FORM_AT[name]] = value
    waves = np.array([machine.load_waves, 0.0, 0.5 * machine.load_waves, 0.0])
    out = np.zeros((len(OUT), SAMPLES))
    size = run_forms(numbers, form, friction, bumps + waves, out)
    pinion, wheel, fx, fy, felt, shown = out[:, :size].copy()
    columns = {
        "time": np.arange(size) * SAMPLE, "plank_position": pinion, "wheel_angle": wheel,
        "fx": fx, "fy": fy, "fz": shown, "felt": felt,
    }  # fmt: skip
    _sensors(columns, tire, machine, run, share)
    return columns


def _sensors(c: Columns, tire: SecondTire, machine: FormsMachine, run: Run, share: float) -> None:
    s = run.setting
    rolls = -np.expm1(-c["plank_position"] / 2e-3)
    angle = c["wheel_angle"] + math.radians(120.0 * (run.start - 1))
    own_fx, own_fy = c["fx"].copy(), c["fy"].copy()
    more = LOAD * ((s.fz / LOAD) ** 1.3 - 1.0) / 1.3
    c["fx"] -= (tire.rolling + machine.rolling_share * more) * rolls
    crest = np.cos(angle - 0.3) + 0.3 * np.cos(2.0 * angle - 0.6)
    c["fx"] += machine.uneven * s.fz / LOAD * crest * rolls
    c["fx"] += machine.parasitic * _rubbing(angle - 1.1)
    c["fz"] += 0.8 * machine.parasitic * _rubbing(angle + 0.4)
    c["mx"] = 0.05 * own_fy + 6.0 * np.sin(c["plank_position"] / 0.25)
    c["mz"] = -0.02 * own_fy + 0.004 * own_fx + 4.0 * np.cos(c["plank_position"] / 0.31)
    true = {k: c[k].copy() for k in LEVELS}
    for (source, goal), amount in machine.mix.items():
        rest = s.fz if source == "fz" else 0.0
        u = true[source] - rest
        c[goal] = c[goal] + amount * (rest + LEVELS[source] * np.tanh(u / LEVELS[source]))
    t = c["time"]
    c["fx"] += machine.drift * t[-1] * fading(t / t[-1], 2.0)
    c["fx"] += machine.drift_runs * (fading(share) - 0.5)
    for _ in range(2):
        c["fx"] = late(c["fx"], 0.5 * machine.lag)
    if machine.skew:
        clock = t - machine.skew * (1.0 + 0.2 * (t / t[-1] - 0.5))
        for name in LEVELS:
            c[name] = np.interp(clock, t, c[name])


def _rubbing(angle: np.ndarray) -> np.ndarray:
    """A saturated cosine; its first harmonic is 1."""
    return np.tanh(1.5 * np.cos(angle)) / 1.01087


Form = Callable[[float, Random], Mapping[str, Any]]


def _kernel(name: str, **fixed: float) -> Form:
    return lambda s, r: {"kernel": {name: s} | fixed}


def _mix(source: str, goal: str, **more: float) -> Form:
    return lambda s, r: {"mix": {(source, goal): s}} | more


def _field(name: str) -> Form:
    return lambda s, r: {name: s}


def _wave(name: str, low: float, high: float) -> Form:
    def form(size: float, random: Random) -> Mapping[str, Any]:
        period, phase = float(random.uniform(low, high)), float(random.random())
        return {"kernel": {name: size, f"{name}_period": period, f"{name}_phase": phase}}

    return form


def _patch(size: float, random: Random) -> Mapping[str, Any]:
    return {"patch": (float(random.uniform(2.0, 3.5)), float(random.uniform(0.1, 0.25)), size)}


MENU_OF_FORMS: dict[str, Form] = {
    "road_play": _kernel("road_gap"),
    "drive_backlash": _kernel("drive_gap"),
    "rack_backlash": _kernel("rack_gap"),
    "support_play_y": _kernel("side_gap"),
    "support_play_z": _kernel("sink_gap"),
    "mesh_ripple": _wave("ripple", 0.03, 0.3),
    "load_undulation": _wave("wave", 0.25, 1.2),
    "speed_droop": _kernel("droop"),
    "load_loss_braking": _kernel("loss"),
    "runout_1": _kernel("out_1"),
    "runout_2": _kernel("out_2"),
    "drive_brake_asymmetry": _kernel("brake_grip"),
    # so that the added deflection at 4 kN is the same
    "carcass_softening": lambda s, r: {"kernel": {"softening": s / 0.79810}},
    "carcass_creep": _kernel("creep"),
    "carcass_load": _field("load_power"),
    "carcass_pressure": _field("pressure_share"),
    "wear": _field("wear"),
    "worn_patch": _patch,
    "parasitic_force": _field("parasitic"),
    "nonuniformity_1": _field("uneven"),
    "crosstalk_fx_fy": _mix("fx", "fy"),
    "crosstalk_fy": _mix("fy", "fx"),
    "crosstalk_fz": _mix("fz", "fx", load_waves=110.0),
    "crosstalk_mx": _mix("mx", "fx"),
    "crosstalk_mz": _mix("mz", "fx"),
    "zero_drift": _field("drift"),
    "zero_drift_runs": _field("drift_runs"),
    "force_lag": _field("lag"),
    "time_skew": _field("skew"),
    "rolling_resistance": _field("rolling_share"),
}
"""effect -> function from its size to fields of FormsMachine"""


def machine_of(sizes: Mapping[str, float], random: Random) -> FormsMachine:
    """Machine with effects of these sizes."""
    fields: dict[str, Any] = {}
    for name, size in sizes.items():
        for key, value in MENU_OF_FORMS[name](size, random).items():
            both = isinstance(value, Mapping) and key in fields
            fields[key] = {**fields[key], **value} if both else value
    return FormsMachine(**fields)


def runs_of_forms(
    tire: SecondTire, runs: Sequence[Run], machine: FormsMachine, scatter
) -> list[Columns]:
    """Make all runs without noise."""
    return [
        measure(
            tire, machine, run, len(runs), float(scatter.gain[run.index]),
            float(scatter.delay[run.index]), scatter.bumps,
        )
        for run in runs
    ]  # fmt: skip
