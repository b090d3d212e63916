# SPDX-License-Identifier: Apache-2.0
"""The simulated bench: one call per bus cycle, from commands to the raw process image."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs, Health
from flatplank_sim.plant import layout
from flatplank_sim.plant.bridges import past_of_bridges
from flatplank_sim.plant.config import PlantConfig
from flatplank_sim.plant.cycle import cycle as run_cycle
from flatplank_sim.plant.layout import Truth
from flatplank_sim.plant.operator import Operator
from flatplank_sim.plant.records import build_records, initial_state
from flatplank_sim.plant.scatter import draw_run, scatters

NOISE_ROWS = 2048
NOISE_CHANNELS = 8
_OK = int(Health.OK)
_ABSENT = AxisInputs(0, 0, 0, 0, 0, 0)


class Plant:
    """The simulated plant. It is deterministic: the same seed and commands give the same samples
    bit for bit."""

    def __init__(self, config: PlantConfig, seed: int = 0, rate_hz: int = 250) -> None:
        if rate_hz <= 0 or 1_000_000_000 % rate_hz:
            raise ValueError(
                f"rate_hz: {rate_hz} Hz has no whole period in ns; use 250, 500, 1000"
            )
        self.config = config
        self.rate_hz = rate_hz
        self._period_ns = 1_000_000_000 // rate_hz
        self._records = r = build_records(config, 1.0 / rate_hz)
        state = initial_state(config, r)
        self._state, self._drive_state = state["state"], state["drive_state"]
        self._tire_state, self._bristles = state["tire_state"], state["bristles"]
        self._commands = np.zeros((len(AXES), layout.COMMAND_FIELDS + 1), np.int64)
        self._volts, self._counts = np.zeros(7), np.zeros(36, np.int64)
        self._truth = np.zeros(len(Truth._fields))
        self._random = np.random.default_rng(seed)
        self._seed, self._scatters, self._drawn = seed, scatters(r), -1
        self._noise = np.empty((NOISE_ROWS, NOISE_CHANNELS))
        self._noisy = any(
            float(r.machine[f"noise_{n}"][0]) > 0.0 for n in ("bridge", "lvdt", "torque")
        )
        self._noise[:] = 0.0
        self._row = NOISE_ROWS
        self._delay = config.command_delay_cycles
        self._waiting: list[deque[AxisCommand]] = [deque() for _ in AXES]
        self._newest = [-1] * len(AXES)
        self._fitted = [axis in config.driven_axes for axis in AXES]
        self.cycle = -1
        self._outputs = [0] * len(AXES)
        self.operator = Operator(config, self._state, state["operator"], r.machine, r.road_map)
        self._arguments = (
            r.machine, self._state, r.tire, self._tire_state, self._bristles, state["operator"],
            r.drives, self._drive_state, self._commands, r.curve, r.road_map, r.mix, r.drift,
            past_of_bridges(float(r.machine["skew"][0]), 1.0 / rate_hz), np.zeros(10), self._noise,
        )  # fmt: skip

    def step(self, commands: Sequence[AxisCommand] = ()) -> BusInputs:
        """Make the next bus cycle; `commands` answer earlier cycles, a repeated one is ignored."""
        self.cycle = count = self.cycle + 1
        for command in commands:
            axis = command[0]
            if command[1] > self._newest[axis]:
                self._newest[axis] = command[1]
                self._waiting[axis].append(command)
        due = count - 1 - self._delay
        for axis, waiting in enumerate(self._waiting):
            while waiting and waiting[0][1] <= due:
                c = waiting.popleft()
                row = self._commands[axis]
                self._outputs[axis] = c[7]
                row[0], row[1], row[2], row[3], row[4], row[5] = c[2], c[3], c[4], c[5], c[6], c[1]
        if self._row >= NOISE_ROWS:
            self._row = 0
            if self._noisy:
                self._random.standard_normal(out=self._noise)
        if self._scatters and self._drawn != (run := int(self._state["run"][0])):
            self._drawn = run
            draw_run(self._records, self._state, np.random.default_rng((self._seed, run)))
        run_cycle(*self._arguments, self._row, count, self._volts, self._counts, self._truth)
        self._row += 1
        v = self._volts.tolist()
        n = self._counts.tolist()
        axes = tuple(
            [
                AxisInputs._make(n[6 + 6 * a : 12 + 6 * a]) if fitted else _ABSENT
                for a, fitted in enumerate(self._fitted)
            ]
        )
        return BusInputs(
            count, count * self._period_ns, (v[0], v[1], v[2], v[3], v[4], v[5]), v[6],
            n[0], n[1], n[2], n[3], n[4], n[5], _OK, axes,
        )  # fmt: skip

    @property
    def digital_outputs(self) -> int:
        """Digital outputs of all axes (OR); bit 0 is the trigger of an optical system."""
        bits = 0
        for own in self._outputs:
            bits |= own
        return bits

    def set_run(self, run: int) -> None:
        """Set the number of runs on the road, for its wear."""
        self._state["run"] = run

    @property
    def truth(self) -> Truth:
        """True forces and motion of the last cycle, hidden from the nodes."""
        return Truth._make(self._truth.tolist())

    @property
    def bristles(self) -> np.ndarray:
        """Bristles from leading to trailing edge: position, deflection x, y [m], sliding flag."""
        t, s = self._records.tire[0], self._tire_state[0]
        j = np.arange(s["last"], s["first"] - 1, -1)
        k = j & (t["ring"] - 1)
        b = self._bristles
        return np.stack([j * t["spacing"] - s["q"], b[0, k], b[1, k], b[4, k]])

    def inject_fault(self, axis: str, code: int = 0x7300) -> None:
        """Inject a drive fault that stays in spite of resets; 0 removes its cause."""
        self._drive(axis)["inject"] = code

    def stick(self, axis: str, stuck: bool = True) -> None:
        """Jam or release the axis mechanically."""
        self._drive(axis)["stuck"] = int(stuck)

    def _drive(self, axis: str) -> np.ndarray:
        if axis not in self.config.driven_axes:
            raise ValueError(
                f"axis '{axis}' has no drive; driven are {', '.join(self.config.driven_axes)}"
            )
        k = AXES.index(axis)
        return self._drive_state[k : k + 1]
