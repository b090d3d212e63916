# SPDX-License-Identifier: Apache-2.0
"""The measurement hub: raw bus image to wrenches and loaded radius."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from flatplank_data.params import require_changes_only
from flatplank_hw.answers import ActionQueue, Answer, refused
from flatplank_hw.bus.image import CHANNELS, BusInputs
from flatplank_hw.encoders.counter import counts_between
from flatplank_hw.hub import parasitic
from flatplank_hw.hub.appendix_a import SOURCES, contact_from_wheel, gains, wheel_from_volts
from flatplank_hw.hub.params import SETUP_CONSTANTS, VOLTS, HubParameters
from flatplank_hw.hub.parasitic import ParasiticFit
from flatplank_hw.samples import HubSample

Channels = tuple[float, float, float, float, float]


class TareStatus(NamedTuple):
    """Status of the last tare."""

    running: bool
    cycle: int
    """first cycle with the present zero; -1: never tared"""
    zero: Channels
    """subtracted from C1, C2, C3, C5, C6 [V]"""
    reason: str
    """why the last tare was abandoned; empty when it was not"""


class Tare:
    """Running tare: sums the samples; `add` returns the mean with the last one."""

    __slots__ = ("_left", "_n", "_sums")

    def __init__(self, samples: int) -> None:
        self._n = self._left = samples
        self._sums = [0.0] * 5

    def add(self, volts: Channels) -> Channels | None:
        """Add one sample; returns the mean with the last one, else None."""
        self._sums = [s + v for s, v in zip(self._sums, volts, strict=True)]
        self._left -= 1
        if self._left:
            return None
        a, b, c, d, e = (s / self._n for s in self._sums)
        return (a, b, c, d, e)


NO_ZERO = (0.0, 0.0, 0.0, 0.0, 0.0)
_TURN = 2.0 * math.pi


class MeasurementHub:
    """Computes bridge volts -> parasitic filter and zero -> (A.1) -> (A.2), and LVDT -> loaded
    radius."""

    def __init__(self, p: HubParameters) -> None:
        self.parameters = p
        self._gains = gains(p)
        self._agenda = ActionQueue()
        self._moment = SOURCES[p.drive_moment_source] if p.include_drive_moment else None
        self._wheel_scale = _TURN / p.wheel_counts_per_turn
        self._camber_scale = _TURN / p.camber_counts_per_turn
        self._camber_zero = math.radians(p.wheel_camber_deg + p.road_camber_offset_deg)
        self._camber_counts: int | None = None
        self._wheel_raw: int | None = None
        self._wheel_counts = 0
        self._plank_raw = 0
        self._moved_at = -math.inf
        self._stamp: int | None = None
        self._period: int | None = None
        self._weight = self._fz = math.nan
        self._tare: Tare | None = None
        self._tare_zero = self._zero = NO_ZERO
        self._tare_cycle, self._tare_reason, self._tare_is_newer = -1, "", False
        self._fit: ParasiticFit | None = None
        self._fit_coming = False
        self._signal: Callable[[float], tuple[float, float, float, float, float]] | None = None
        self._filter_on = False
        if p.parasitic_fit:
            self._use_fit(parasitic.load_fit(p.parasitic_fit))
        if p.filter_on:
            if self._fit is None:
                raise ValueError(
                    "measurement hub: filter_on needs parasitic_fit, the file of a fit"
                )
            self._switch(True)

    # requests
    def set_constants(self, p: HubParameters) -> None:
        """Change set-up constants from the next cycle on; ValueError for any other change."""
        require_changes_only(self.parameters, p, SETUP_CONSTANTS, "measurement hub")
        self.parameters, self._gains = p, gains(p)
        self._camber_zero = math.radians(p.wheel_camber_deg + p.road_camber_offset_deg)
        self._camber_counts = None

    def tare(self) -> Answer:
        """Average `tare_samples` samples from the next cycle on and use the mean as zero."""
        if self._tare is not None:
            return refused("a tare is running")
        if self._stamp is None:
            return refused("no inputs yet: start the bus")
        if self._moves(self._stamp):
            return refused("the plank moves: stop it, then tare")
        if not abs(self._fz) <= self.parameters.tare_limit_fz:
            return refused(f"Fz is {self._fz:.0f} N: unload the tire, then tare")
        return self._agenda.accept(
            self._start_tare,
            f"the mean of {self.parameters.tare_samples} samples becomes the zero",
        )

    def set_filter(self, on: bool) -> Answer:
        """Switch the parasitic filter on or off."""
        if on and self._fit is None and not self._fit_coming:
            return refused("no parasitic fit is loaded: load the file of this mounting first")
        return self._agenda.accept(
            lambda: self._switch(on), f"the parasitic filter is {'on' if on else 'off'}"
        )

    def load_fit(self, path: str) -> Answer:
        """Load the fit of a mounting from its file."""
        if not path:
            return refused("no file is named: give the path of a parasitic fit")
        try:
            fit = parasitic.load_fit(path)
        except ValueError as error:
            return refused(str(error))
        return self.use_fit(fit)

    def use_fit(self, fit: ParasiticFit) -> Answer:
        """Use an identified fit."""
        self._fit_coming = True
        return self._agenda.accept(
            lambda: self._use_fit(fit), "the parasitic fit of this mounting is in use"
        )

    # status
    @property
    def fit(self) -> ParasiticFit | None:
        """The loaded fit, whether the filter is on or not."""
        return self._fit

    @property
    def tare_status(self) -> TareStatus:
        """Status of the last tare and the present zero."""
        return TareStatus(self._tare is not None, self._tare_cycle, self._zero, self._tare_reason)

    # the cycle
    def step(self, inputs: BusInputs) -> HubSample:
        """Return the sample of one bus cycle; takes about 5 us."""
        cycle, stamp = inputs.cycle, inputs.stamp_ns
        agenda = self._agenda
        if agenda.due:
            agenda.run()
        agenda.last_cycle = cycle
        self._watch_plank(inputs.plank_counts, stamp)

        volts = inputs.bridge_volts
        high = self.parameters.saturation_volts
        saturated = sum(1 << i for i, c in enumerate(volts) if not -high < c < high)
        c1, c2, c3, c4, c5, c6 = (c if VOLTS.admits(c) else math.nan for c in volts)
        if self._filter_on and self._signal is not None:
            s1, s2, s3, s5, s6 = self._signal(self._wheel_angle(inputs.wheel_counts))
            c1, c2, c3, c5, c6 = c1 - s1, c2 - s2, c3 - s3, c5 - s5, c6 - s6
        elif self._fit is not None:
            self._wheel_angle(inputs.wheel_counts)
        if self._tare is not None:
            self._run_tare((c1, c2, c3, c5, c6), stamp)
        z1, z2, z3, z5, z6 = self._zero
        volts = (c1 - z1, c2 - z2, c3 - z3, c4, c5 - z5, c6 - z6)

        p = self.parameters
        lvdt = inputs.lvdt_volts
        if not VOLTS.admits(lvdt):
            lvdt, saturated = math.nan, saturated | 1 << CHANNELS
        radius = p.lvdt_offset + p.lvdt_gain * lvdt
        if inputs.camber_counts != self._camber_counts:
            self._set_camber(inputs.camber_counts)
        wheel = wheel_from_volts(volts, self._gains)
        if self._moment is not None:
            wheel = wheel._replace(my=self._moment(inputs, wheel.fx, radius, p))
        contact = contact_from_wheel(wheel, radius, self._cos, self._sin)
        return HubSample(
            cycle, stamp, wheel, contact, radius, self._camber, self._low_pass(contact.fz, stamp),
            self._filter_on, saturated,
        )  # fmt: skip

    def _low_pass(self, fz: float, stamp: int) -> float:
        """Low-passed Fz [N]; NaN where there is no Fz, without a trace in later samples."""
        period = None if self._stamp is None else stamp - self._stamp
        if period is not None and period != self._period:
            self._period = period
            # exact response of a first-order low-pass to a zero-order hold
            self._weight = 1.0 - math.exp(
                -_TURN * self.parameters.fz_filter_hz * max(period, 0) * 1e-9
            )
        self._stamp = stamp
        if fz != fz:
            return fz
        self._fz = fz if self._fz != self._fz else self._fz + self._weight * (fz - self._fz)
        return self._fz

    def _set_camber(self, counts: int) -> None:
        self._camber_counts = counts
        self._camber = self._camber_zero + counts * self._camber_scale
        self._cos, self._sin = math.cos(self._camber), math.sin(self._camber)

    def _wheel_angle(self, raw: int) -> float:
        if self._wheel_raw is None:
            self._wheel_counts = raw
        else:
            self._wheel_counts += counts_between(self._wheel_raw, raw)
        self._wheel_raw = raw
        return self._wheel_counts * self._wheel_scale

    def _watch_plank(self, raw: int, stamp: int) -> None:
        if not -2 < counts_between(self._plank_raw, raw) < 2:
            if self._stamp is not None:
                self._moved_at = stamp
            self._plank_raw = raw

    def _moves(self, stamp: int) -> bool:
        return stamp - self._moved_at < self.parameters.still_time * 1e9

    # effects of requests
    def _start_tare(self) -> None:
        self._tare, self._tare_reason = Tare(self.parameters.tare_samples), ""

    def _run_tare(self, volts: tuple[float, float, float, float, float], stamp: int) -> None:
        if self._moves(stamp):
            self._tare, self._tare_reason = None, "the plank moved during the tare: zero unchanged"
            return
        if not all(math.isfinite(v) for v in volts):
            self._tare, self._tare_reason = None, "a bridge gave no number: zero unchanged"
            return
        mean = self._tare.add(volts) if self._tare is not None else None
        if mean is not None:
            self._tare, self._tare_zero, self._tare_is_newer = None, mean, True
            self._tare_cycle = self._agenda.last_cycle
            self._choose_zero()

    def _use_fit(self, fit: ParasiticFit) -> None:
        self._fit, self._signal, self._tare_is_newer = fit, fit.signal(), False
        self._choose_zero()

    def _switch(self, on: bool) -> None:
        self._filter_on = on and self._fit is not None
        self._choose_zero()

    def _choose_zero(self) -> None:
        """Choose the zero: D of the fit when the filter is on and the fit is newer than the tare;
        else the tare."""
        if self._filter_on and self._fit is not None and not self._tare_is_newer:
            self._zero = self._fit.offsets
        else:
            self._zero = self._tare_zero
