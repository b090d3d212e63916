# SPDX-License-Identifier: Apache-2.0
"""A machine with one degree of freedom, integrated for all runs at once, and effects that it may
lack. Fitted parameters are declared as `name = param(...)` and passed to the methods.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Iterator, Sequence
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.parameters import Parameter
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.machines.records import BEGIN, FINE, between


def parameters_in(kind: type) -> tuple[Parameter, ...]:
    """Fields made by `param` in a class and its base classes, in order."""
    found: dict[str, Parameter] = {}
    for part in reversed(kind.__mro__):
        for name, item in vars(part).items():
            if isinstance(item, dataclasses.Field) and "parameter" in item.metadata:
                found[name] = Parameter(name, **item.metadata["parameter"])
    return tuple(found.values())


def named(names: Iterable[str], values: np.ndarray) -> SimpleNamespace:
    """Values (sets, parameters) by name, each (sets, 1)."""
    return SimpleNamespace(**{n: values[:, i, None] for i, n in enumerate(names)})


class Missing(Effect):
    """An effect that a `Motion` may lack.

    A subclass has parameters made by `param`, and one or more of the methods `force`, `damping`
    and `friction`, with the arguments (p, s) of those of `Motion`. By default the identifier is
    the name of the class (`LoadFriction`: load_friction), the title the first sentence of its
    docstring, and `what` the rest. `check` says how to test the machine for the effect, `removes`
    how to remove it, `coordinate` over which coordinate it shows.
    """

    coordinate = "speed"

    def __init_subclass__(cls) -> None:
        for parameter in parameters_in(cls):
            cls.__annotations__.setdefault(parameter.name, float)
        dataclasses.dataclass(frozen=True)(cls)
        words = re.sub(r"\s+", " ", cls.__doc__ or "").strip()
        title, _, rest = words.partition(". ")
        snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower()
        cls.identifier = vars(cls).get("identifier") or snake
        cls.title = vars(cls).get("title") or title.rstrip(".")
        cls.what = vars(cls).get("what") or rest or words


class Motion:
    """Equation of motion: inertia d2x/dt2 = force - damping dx/dt, with dry friction.

    A subclass has parameters made by `param` and some of the methods below. `p` has the parameters
    by name; `s` has the position `x`, the speed `v`, the time `t` and, by name, facts and inputs
    of the records. All are arrays that broadcast; a method returns one.
    """

    steps: ClassVar[int] = 6
    """integration steps between two nodes"""
    scatters: ClassVar[tuple[str, ...]] = ()
    """names of parameters that scatter from record to record"""
    parameters: tuple[Parameter, ...] = ()

    def __init_subclass__(cls) -> None:
        cls.parameters = parameters_in(cls)

    def __init__(self, runs: RunSet) -> None:
        self.runs = runs

    def force(self, p: Any, s: Any) -> Any:
        """Driving and restoring force, without friction."""
        return 0.0

    def damping(self, p: Any, s: Any) -> Any:
        """Damping coefficient: resisting force over speed, not negative."""
        return 0.0

    def friction(self, p: Any, s: Any) -> Any:
        """Dry friction: its value in motion, its upper limit at rest."""
        return 0.0

    def inertia(self, p: Any, s: Any) -> Any:
        """Mass or inertia; 1 where forces are accelerations."""
        return 1.0

    def load(self, p: Any, s: Any) -> Any:
        """Load on which friction may depend; effects read it as `s.load`."""
        return 0.0

    def begin(self, p: Any, s: Any) -> tuple[Any, Any]:
        """Position and speed at the first node; by default those of the record in `s`."""
        return s.x, s.v

    def scatter_directions(self, base: np.ndarray) -> tuple[dict[str, float], ...]:
        """Directions that scatter from record to record."""
        return tuple({name: 1.0} for name in self.scatters)

    def predict(self, sets: Sequence[ParameterSet]) -> np.ndarray:
        """Position (sets, 1, runs, nodes)."""
        names = [parameter.name for parameter in self.parameters]
        p = named(names, np.array([one.base for one in sets], dtype=float))
        added = list(_added(sets))
        runs, shape = self.runs, (len(sets), self.runs.runs)
        s = SimpleNamespace(**runs.facts, sets=len(sets))
        s.x, s.v = (np.broadcast_to(runs.facts[k], shape) for k in BEGIN)
        x, v = (np.broadcast_to(v, shape) for v in self.begin(p, s))
        out = np.empty((len(sets), 1, *runs.time.shape))
        node = np.diff(runs.time, axis=1)
        for n in range(runs.samples - 1):
            out[:, 0, :, n] = x
            dt = node[:, n] / self.steps
            for i in range(self.steps):
                # leapfrog: forces at the middle of the step
                x = x + 0.5 * dt * v
                self._at(s, n, (i + 0.5) / self.steps, x, v)
                s.v = self._speed(p, s, added, v, 0.5 * dt)
                v = self._speed(p, s, added, v, dt)
                x = x + 0.5 * dt * v
        out[:, 0, :, -1] = x
        return out

    def _at(self, s: Any, n: int, share: float, x: np.ndarray, v: np.ndarray) -> None:
        """Set state, time and inputs between node n and the next."""
        s.x, s.v = x, v
        s.t = self.runs.time[:, n] + share * (self.runs.time[:, n + 1] - self.runs.time[:, n])
        for name in self.runs.inputs:
            setattr(s, name, self.runs.facts[between(name)][:, round(FINE * (n + share))])

    def _speed(self, p: Any, s: Any, added: Sequence[_Added], v: Any, dt: np.ndarray) -> Any:
        """Speed one time step after v, with the forces at state s; stable for any damping and
        friction."""
        s.load = self.load(p, s)
        force, damping, friction = self.force(p, s), self.damping(p, s), self.friction(p, s)
        for effect, rows, values in added:
            here = s if rows is None else _of_sets(s, rows)
            force = _sum(force, effect, "force", values, here, rows)
            damping = _sum(damping, effect, "damping", values, here, rows)
            friction = _sum(friction, effect, "friction", values, here, rows)
        step = dt / self.inertia(p, s)
        half = 0.5 * step * damping
        free = ((1.0 - half) * v + step * force) / (1.0 + half)
        most = step * friction / (1.0 + half)
        return free - np.minimum(np.maximum(free, -most), most)


def _of_sets(s: Any, rows: np.ndarray) -> Any:
    """The state of some parameter sets."""
    here = SimpleNamespace(**vars(s))
    here.x, here.v = s.x[rows], s.v[rows]
    here.load = s.load[rows] if np.ndim(s.load) == 2 else s.load
    return here


def _sum(own: Any, effect: type[Effect], name: str, values: Any, s: Any, rows: Any) -> Any:
    """A model's value plus that of an effect in its parameter sets; rows None: in all."""
    if not hasattr(effect, name):
        return own
    more = getattr(effect, name)(values, s)
    if rows is None:
        return own + more
    total = np.array(np.broadcast_to(own, (s.sets, s.x.shape[1])), dtype=float)
    total[rows] += more
    return total


_Added = tuple[type[Effect], np.ndarray | None, SimpleNamespace]


def _added(sets: Sequence[ParameterSet]) -> Iterator[_Added]:
    """Each instance of an effect with the sets that have it (None: all) and its values."""
    found: dict[tuple[type[Effect], int], list[tuple[int, np.ndarray]]] = {}
    for i, one in enumerate(sets):
        seen: dict[type[Effect], int] = {}
        for effect, values in one.effects:
            seen[effect] = seen.get(effect, -1) + 1
            found.setdefault((effect, seen[effect]), []).append((i, values))
    for (effect, _), entries in found.items():
        names = [parameter.name for parameter in effect.parameters()]
        values = named(names, np.array([v for _, v in entries], dtype=float))
        rows = None if len(entries) == len(sets) else np.array([i for i, _ in entries])
        yield effect, rows, values
