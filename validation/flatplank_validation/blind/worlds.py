# SPDX-License-Identifier: Apache-2.0
"""The simulated worlds of the blind campaigns: the plant with its brush-model tire, the second
tire and machine, the same tire on a machine whose faults have other forms. For combined slip: the
second tire with a friction circle, and the third tire."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from flatplank_sim.plant.campaign import Campaign, CampaignRun
from flatplank_sim.plant.config import PlantConfig
from flatplank_sim.sealed.conditions import STEP, Columns, Run
from flatplank_validation.blind import forms
from flatplank_validation.blind.menu import MENU
from flatplank_validation.blind.second import SecondMachine, SecondTire, counted, measure
from flatplank_validation.blind.third_world import HIDES, ThirdWorld

Sizes = Mapping[str, float]
KEPT = ("time", "plank_position", "wheel_angle", "fx", "fy", "fz", "mx", "mz")


@dataclass(frozen=True)
class Scatter:
    """Scatter from run to run in one campaign; arrays of shape (runs,)."""

    gain: np.ndarray
    """factor of grip and tread stiffness"""
    delay: np.ndarray
    """delay of the wheel at the start [s]"""
    bumps: np.ndarray
    """load undulation over the plank: size, phase, size, phase"""

    @classmethod
    def drawn(cls, count: int, level: float, random: np.random.Generator) -> Scatter:
        """Random scatter of one campaign."""
        bumps = np.array([12.0, 6.28 * random.random(), 8.0, 6.28 * random.random()])
        delay = 0.09 + 0.03 * random.random(count)
        return cls(1.0 + level * random.standard_normal(count), delay, bumps)

    @classmethod
    def none(cls, count: int) -> Scatter:
        """No scatter."""
        return cls(np.ones(count), np.full(count, 0.1), np.array([12.0, 0.3, 8.0, 1.1]))


class World(Protocol):
    """Interface of a world: makes runs without noise, with quantised encoders."""

    @property
    def radius(self) -> float:
        """Effective rolling radius [m]."""

    def has(self, name: str) -> bool:
        """True when the world can hide this effect."""

    def run(
        self, runs: Sequence[Run], sizes: Sizes, random: np.random.Generator, scatter: Scatter
    ) -> list[Columns]:
        """Make all runs with effects of these sizes."""

    def nuisances(self) -> tuple[Mapping[str, float], ...]:
        """Small changes of the tire that a fit of the tire can absorb."""

    def changed(self, change: Mapping[str, float]) -> World:
        """The same world with a changed tire."""


@dataclass(frozen=True)
class SecondWorld:
    """World of the second tire; see second_kernel.py."""

    tire: SecondTire = field(default_factory=SecondTire)
    radius: float = 0.3108

    @classmethod
    def drawn(cls, random: np.random.Generator) -> SecondWorld:
        """World with a random tire."""
        return cls(SecondTire().drawn(random))

    def has(self, name: str) -> bool:
        return MENU[name].second is not None

    def run(self, runs, sizes, random, scatter) -> list[Columns]:
        machine = self._machine(sizes, random)
        return [
            counted(
                measure(
                    self.tire, machine, run, len(runs), float(scatter.gain[run.index]),
                    float(scatter.delay[run.index]), scatter.bumps,
                )
            )
            for run in runs
        ]  # fmt: skip

    @staticmethod
    def _machine(sizes: Sizes, random: np.random.Generator) -> SecondMachine:
        fields: dict[str, Any] = {}
        for name, size in sizes.items():
            second = MENU[name].second
            assert second is not None, "asked by has()"
            for key, value in second(size, random).items():
                both = isinstance(value, Mapping) and key in fields
                fields[key] = {**fields[key], **value} if both else value
        return SecondMachine(**fields)

    def nuisances(self) -> tuple[Mapping[str, float], ...]:
        t = self.tire
        part = {n: 0.01 * getattr(t, n) for n in ("tread_x", "tread_y", "half", "grip")}
        part |= {n: 0.03 * getattr(t, n) for n in ("carcass_x", "carcass_y")}
        part |= {"grip_lost": 0.02, "grip_speed": 5e-4, "rolling": 5.0, "offset": 2e-4}
        return tuple({name: step} for name, step in part.items())

    def changed(self, change) -> SecondWorld:
        new = {name: getattr(self.tire, name) + step for name, step in change.items()}
        return replace(self, tire=replace(self.tire, **new))


@dataclass(frozen=True)
class FormsWorld(SecondWorld):
    """World of the second tire on the machine of forms.py."""

    def has(self, name: str) -> bool:
        return name in forms.MENU_OF_FORMS

    def run(self, runs, sizes, random, scatter) -> list[Columns]:
        machine = forms.machine_of(sizes, random)
        return [counted(c) for c in forms.runs_of_forms(self.tire, runs, machine, scatter)]


@dataclass(frozen=True)
class CircleWorld(SecondWorld):
    """World of the second tire with one friction limit for both directions."""

    def has(self, name: str) -> bool:
        return name in HIDES and super().has(name)

    @classmethod
    def drawn(cls, random: np.random.Generator | None = None) -> CircleWorld:
        """World with a random tire; without a generator, the nominal one."""
        tire = SecondTire() if random is None else SecondTire().drawn(random)
        return cls(replace(tire, circle=1.0))


@dataclass(frozen=True)
class PlantWorld:
    """World of the simulated plant, without bus and hub: `flatplank_sim.plant.campaign`."""

    tire: Mapping[str, float]
    radius: float = 0.31088
    rate: float = 20.0

    @classmethod
    def drawn(cls, random: np.random.Generator | None = None) -> PlantWorld:
        """World with the Toyo, or a random tire like it."""
        plain = PlantConfig.load("toyo").tire
        names = (
            "friction", "tread_stiffness_x", "tread_stiffness_y", "carcass_stiffness_x",
            "contact_half_length", "rolling_resistance",
        )  # fmt: skip
        low, high = (1.0, 1.0) if random is None else (0.94, 1.06)
        draw = np.random.default_rng(0) if random is None else random
        return cls({n: getattr(plain, n) * draw.uniform(low, high) for n in names})

    def has(self, name: str) -> bool:
        return MENU[name].plant is not None

    def run(self, runs, sizes, random, scatter) -> list[Columns]:
        defects: dict[str, Any] = {"mains_hum": None, "sensor_noise": {"bridge": 0.0}}
        for name, size in sizes.items():
            plant = MENU[name].plant
            assert plant is not None, "asked by has()"
            defects |= plant(size, random)
        return [self._one(run, defects, scatter) for run in runs]

    def _one(self, run: Run, defects: Mapping[str, Any], scatter: Scatter) -> Columns:
        gain, s = float(scatter.gain[run.index]), run.setting
        tire = dict(self.tire)
        for name in ("friction", "tread_stiffness_x"):
            tire[name] = tire[name] * gain
        config = PlantConfig.load("toyo", overrides={"defects": defects, "tire": tire})
        wanted = CampaignRun(
            kappa=s.kappa, fz=s.fz, pressure=s.pressure, alpha=math.radians(s.alpha_deg),
            gamma=math.radians(s.gamma_deg), start_angle=math.radians(120.0 * (run.start - 1)),
            run_index=run.index, effective_rolling_radius=self.radius, step_position=STEP,
            start_delay=float(scatter.delay[run.index]),
        )  # fmt: skip
        bench = Campaign(config, rate_hz=self.rate, tire_step=0.0125)
        columns = bench.run(wanted, np.random.default_rng(run.index))
        return {name: columns[name] for name in KEPT}

    def nuisances(self) -> tuple[Mapping[str, float], ...]:
        own = tuple({name: 0.02 * value} for name, value in self.tire.items())
        return (*own, {"radius": 6e-5})

    def changed(self, change) -> PlantWorld:
        new = {name: value + change.get(name, 0.0) for name, value in self.tire.items()}
        return PlantWorld(new, self.radius + change.get("radius", 0.0), self.rate)


WORLDS: dict[str, Callable[[np.random.Generator | None], World]] = {
    "plant": PlantWorld.drawn,
    "second": lambda random: SecondWorld() if random is None else SecondWorld.drawn(random),
    "forms": lambda random: FormsWorld() if random is None else FormsWorld.drawn(random),
    "circle": CircleWorld.drawn,
    "third": ThirdWorld.drawn,
}
COMBINED = ("circle", "third")
"""worlds of combined slip and several loads, scored in a separate row"""
PRESENT = {"circle": ("combined_slip",), "third": ("combined_slip", "rolling_resistance")}
"""world -> effects that its tires really have; naming them is right"""
