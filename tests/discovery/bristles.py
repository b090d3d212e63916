# SPDX-License-Identifier: Apache-2.0
"""Made-up campaigns with a known truth. Shares no formula with the base of the search.

Two tires: bristles that are carried through the patch and clipped by friction one by one, and a
first-order relaxation with a Magic Formula. Encoders count in whole steps, forces carry white and
red noise, the wheel starts late by a different time in every run.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import yaml

from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable

SLIPS = (-0.1, -0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05, 0.1)
STEP, RADIUS, LOAD, DT = 1.5, 0.3108, 3700.0, 0.05


@dataclass
class Truth:
    """What is switched on; everything off by default."""

    seed: int = 0
    tire: str = "bristles"
    slips: tuple[float, ...] = SLIPS
    repeats: int = 3
    scatter: float = 0.0
    """gain of the tire from run to run"""
    noise: float = 1.0
    color: float = 1.0
    """share of red noise"""
    play: float = 0.0
    backlash: float = 0.0
    parasitic: float = 0.0
    asymmetry: float = 0.0
    ripple: float = 0.0
    ripple_period: float = 0.05
    patch: float = 0.0
    patch_place: tuple[float, float] = (2.3, 2.5)
    lag: float = 0.0
    skew: float = 0.0
    wear: float = 0.0
    runout: float = 0.0
    crosstalk_fy: float = 0.0
    drift_runs: float = 0.0
    pull: float = 0.0
    """a force between 2.0 and 2.8 m in driving runs: in no library"""
    steps: dict[str, float] = field(default_factory=dict)


class _Bristles:
    """Bristles in cells along the patch, one row per run."""

    def __init__(self, rng, runs: int) -> None:
        self.cells, self.half = 56, 0.072 * rng.uniform(0.95, 1.05)
        self.stiff = 9.6e4 * rng.uniform(0.95, 1.05) / (2.0 * self.half**2)
        self.carcass = 2.3e5 * rng.uniform(0.93, 1.07)
        self.mu = 1.05 * rng.uniform(0.97, 1.03)
        self.cell = 2.0 * self.half / self.cells
        x = (np.arange(self.cells) + 0.5) / self.cells * 2.0 - 1.0
        self.shape = 0.75 * (1.0 - x**2) / self.half
        self.bend = np.zeros((runs, self.cells))
        self.u = np.zeros(runs)

    def step(self, travel, slip, rolled, load, gain, friction):
        share = np.clip(rolled / self.cell, 0.0, 1.0)[:, None]
        carried = (1.0 - share) * self.bend
        carried[:, 1:] += share * self.bend[:, :-1]
        # a bristle that enters during the step has bent for half of it
        limit = (self.mu * friction * load)[:, None] * self.shape / self.stiff
        du = np.zeros(len(slip))
        for _ in range(6):
            bent = carried + (slip - du)[:, None]
            bent[:, 0] -= 0.5 * share[:, 0] * (slip - du)
            held = np.abs(bent) < limit
            bent = np.clip(bent, -limit, limit)
            force = gain * self.stiff * self.cell * bent.sum(axis=1)
            slope = gain * self.stiff * self.cell * held.sum(axis=1) + self.carcass
            du = du + (force - self.carcass * (self.u + du)) / slope
        self.u = self.u + du
        self.bend = bent
        return force


class _Relaxation:
    """One state per run: transient slip with a relaxation length that shrinks with the slip."""

    def __init__(self, rng, runs: int) -> None:
        self.k = 9.4e4 * rng.uniform(0.95, 1.05)
        self.d, self.c = 1.05 * rng.uniform(0.97, 1.03), 1.55
        self.carcass, self.patch = 2.35e5 * rng.uniform(0.93, 1.07), 0.07
        self.slip = np.zeros(runs)

    def law(self, s, load, gain, friction):
        peak = self.d * friction * load
        b = self.k / (self.c * peak)
        return gain * peak * np.sin(self.c * np.arctan(b * s))

    def step(self, travel, slip, rolled, load, gain, friction):
        old = self.law(self.slip, load, gain, friction)
        new = self.slip.copy()
        for _ in range(8):
            f = self.law(new, load, gain, friction)
            g = (self.law(new + 1e-6, load, gain, friction) - f) / 1e-6
            miss = self.patch * (new - self.slip) + travel * new + (f - old) / self.carcass - slip
            new = new - miss / (self.patch + travel + np.maximum(g, 0.0) / self.carcass)
        self.slip = new
        return self.law(new, load, gain, friction)


TIRES = {"bristles": _Bristles, "relaxation": _Relaxation}


def campaign(truth: Truth) -> list[MeasurementTable]:
    """All runs of a campaign, in random order."""
    rng = np.random.default_rng(truth.seed)
    plan = [(k, s) for k in truth.slips for s in range(1, truth.repeats + 1)]
    plan = [plan[i] for i in rng.permutation(len(plan))]
    return _measure(truth, rng, plan, *_run_all(truth, rng, plan))


def save(tables: list[MeasurementTable], folder: Path) -> Path:
    """The runs as a campaign on disk."""
    for table in tables:
        columns = pa.table({k: v for k, v in table.columns.items()})
        pq.write_table(columns, folder / table.info.file)
    records = [table.info.to_dict() for table in tables]
    text = {"format": "flatplank-measurement-table/1", "tire": "MADE", "runs": records}
    (folder / "campaign.yaml").write_text(yaml.safe_dump(text))
    return folder


def _run_all(truth: Truth, rng, plan):
    """True motion and forces; arrays (runs, samples)."""
    runs, sub = len(plan), 2
    kappa = np.array([k for k, _ in plan])
    start = np.radians([120.0 * (s - 1) for _, s in plan])
    total = int(137.0 / DT) * sub
    h = DT / sub
    delay = 0.62 + 0.03 * rng.random(runs)
    tire = TIRES[truth.tire](rng, runs)
    gain = 1.0 + truth.scatter * rng.standard_normal(runs)
    order = np.arange(runs) / max(runs - 1, 1)
    grip = 1.0 - truth.wear * order
    plank = np.zeros(runs)
    wheel = np.zeros(runs)
    speed = np.zeros(runs)
    phase = rng.uniform(0.0, 2.0 * np.pi)
    s_road = np.zeros(runs)
    play = np.full(runs, -0.5 * truth.play)
    lost = np.zeros(runs)
    force = np.zeros(runs)
    out = {k: np.zeros((runs, total // sub)) for k in ("plank", "wheel", "fx", "load", "true")}
    for n in range(total):
        if n * h > 0.5:
            speed = np.minimum(speed + 0.206 * h, 0.03092)
        travel = speed * h * (1.0 + 1e-7 * force)
        on = n * h > delay
        rate = 0.0309 * np.where(plank > STEP, 1.0 + kappa, 1.0) * on
        turned = rate * h * (1.0 - 0.0008)
        wheel = wheel + turned
        plank = plank + travel
        angle = wheel / RADIUS + start
        real_turned = turned * (1.0 + truth.runout / RADIUS * np.cos(angle - 0.7))
        ripple = truth.ripple * np.sin(2 * np.pi * plank / truth.ripple_period + phase)
        real_travel = travel + ripple - s_road
        s_road = ripple
        slip = real_turned - real_travel
        if truth.backlash:
            wish = np.where(plank > STEP, turned * kappa / (1.0 + kappa), 0.0)
            room = truth.backlash - np.abs(lost)
            eaten = np.sign(wish) * np.minimum(np.abs(wish), np.maximum(room, 0.0))
            lost = lost + eaten
            slip = slip - eaten
        if truth.play:
            slip, play = _through_play(truth, force, slip, play)
        load = (
            LOAD + 12.0 * np.sin(2 * np.pi * plank / 1.3) + 8.0 * np.cos(2 * np.pi * plank / 0.5)
        )
        load = load + 12.0 * np.cos(angle - 0.5)
        friction = grip.copy()
        friction = np.where(force < 0.0, friction * (1.0 - truth.asymmetry), friction)
        low, high = truth.patch_place
        friction = np.where((plank > low) & (plank < high), friction * (1 - truth.patch), friction)
        force = tire.step(real_travel, slip, real_turned, load, gain, friction)
        if n % sub == sub - 1:
            i = n // sub
            out["plank"][:, i], out["wheel"][:, i] = plank, wheel / RADIUS
            out["fx"][:, i] = force - 25.0 * (plank > 0.0005)
            out["load"][:, i], out["true"][:, i] = load, force
    keep = out["plank"].min(axis=0) < 4.15
    return {k: v[:, keep] for k, v in out.items()}, kappa, start


def _through_play(truth: Truth, force, slip, play):
    """While the force would change its sign the plank moves through its play instead."""
    # one step may carry the force past zero
    at_zero = np.abs(force) < 1.0 + 2.0e5 * np.abs(slip)
    half = 0.5 * truth.play
    free = np.where(slip > 0.0, half - play, -half - play)
    free = np.where(slip > 0.0, np.maximum(free, 0.0), np.minimum(free, 0.0))
    crossing = at_zero & (np.abs(free) > 0.0)
    moved = np.where(crossing, np.sign(slip) * np.minimum(np.abs(slip), np.abs(free)), 0.0)
    return slip - moved, play + moved


def _measure(truth: Truth, rng, plan, out, kappa, start) -> list[MeasurementTable]:
    runs, samples = out["fx"].shape
    time = np.arange(samples) * DT
    order = np.arange(runs) / max(runs - 1, 1)
    fx = out["fx"].copy()
    angle = out["wheel"] + start[:, None]
    fx += truth.parasitic * np.cos(angle - 1.1)
    fz = out["load"] + 0.8 * truth.parasitic * np.cos(angle + 0.4)
    if truth.lag:
        keep, raw = np.exp(-DT / truth.lag), fx.copy()
        for i in range(1, samples):
            mean = 0.5 * (raw[:, i - 1] + raw[:, i])
            fx[:, i] = keep * fx[:, i - 1] + (1.0 - keep) * mean
    fy = 40.0 * (1.0 - np.exp(-out["plank"] / 0.3))
    fx += truth.crosstalk_fy * fy + truth.drift_runs * order[:, None]
    pulled = (out["plank"] > 2.0) & (out["plank"] < 2.8) & (kappa[:, None] > 0.0)
    fx += truth.pull * np.where(pulled, np.sin(np.pi * (out["plank"] - 2.0) / 0.8), 0.0)
    if truth.skew:
        fx = np.stack([np.interp(time - truth.skew, time, row) for row in fx])
        fy = np.stack([np.interp(time - truth.skew, time, row) for row in fy])
    n = truth.noise
    fx = fx + n * (
        10.0 * rng.standard_normal(fx.shape) + truth.color * _red(rng, fx.shape, 40.0, 8.0)
    )
    fy = fy + n * (10.0 * rng.standard_normal(fx.shape) + _red(rng, fx.shape, 40.0, 4.0))
    fz = fz + n * (10.0 * rng.standard_normal(fx.shape) + _red(rng, fx.shape, 40.0, 5.0))
    tables = []
    wheel_step, plank_step = 2 * np.pi / 20000, 2 * np.pi * 0.05 / 20000
    for i, (k, s) in enumerate(plan):
        columns = {
            "time": time,
            "plank_position": np.floor(out["plank"][i] / plank_step) * plank_step,
            "wheel_angle": np.floor(out["wheel"][i] / wheel_step) * wheel_step,
            "fx": fx[i],
            "fy": fy[i],
            "fz": fz[i],
        }
        info = RunRecord(
            file=f"run_{i:02d}_{100 * k:+g}_{s}.parquet", tire="MADE", kappa=k, fz=LOAD,
            pressure=2.5, start=s, run_index=i, effective_rolling_radius=RADIUS,
            step_position=STEP,
        )  # fmt: skip
        tables.append(MeasurementTable(columns, info))
    return tables


def _red(rng, shape, constant: float, size: float) -> np.ndarray:
    keep = np.exp(-DT / constant)
    push = size * np.sqrt(1.0 - keep**2) * rng.standard_normal(shape)
    out = np.empty(shape)
    out[:, 0] = size * rng.standard_normal(shape[0])
    for i in range(1, shape[1]):
        out[:, i] = keep * out[:, i - 1] + push[:, i]
    return out
