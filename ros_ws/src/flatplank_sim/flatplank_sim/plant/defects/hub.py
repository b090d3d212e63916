# SPDX-License-Identifier: Apache-2.0
"""Defects of the measurement hub and the other instruments."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, defect_param


@dataclass(frozen=True)
class Crosstalk(Defect):
    """Crosstalk: a force of the hub appears in the channel of another.

    The error is proportional to the other force, independent of slip.
    """

    fz_to_fx: float = defect_param(0.01, "-", "Fx per Fz", (-0.5, 0.5))
    fx_to_fz: float = defect_param(0.0, "-", "Fz per Fx", (-0.5, 0.5))
    fx_to_fy: float = defect_param(0.01, "-", "Fy per Fx", (-0.5, 0.5))
    fy_to_fx: float = defect_param(0.0, "-", "Fx per Fy", (-0.5, 0.5))
    fz_to_fy: float = defect_param(0.0, "-", "Fy per Fz", (-0.5, 0.5))

    source = "thesis 3.1, hardware issue 19"
    touches = frozenset({"fx", "fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fx_true"})

    def install(self, site: Site) -> None:
        mix = site.mix
        mix[0, 2] += self.fz_to_fx
        mix[2, 0] += self.fx_to_fz
        mix[1, 0] += self.fx_to_fy
        mix[0, 1] += self.fy_to_fx
        mix[1, 2] += self.fz_to_fy


@dataclass(frozen=True)
class HubGain(Defect):
    """The calibration of the measurement hub is outdated.

    The bridges scale the forces and moments at the wheel centre by wrong factors.
    """

    fx: float = defect_param(0.02, "-", "relative error of Fx", (-0.5, 0.5))
    fy: float = defect_param(0.0, "-", "of Fy", (-0.5, 0.5))
    fz: float = defect_param(0.01, "-", "of Fz", (-0.5, 0.5))
    mx: float = defect_param(0.0, "-", "of Mx", (-0.5, 0.5))
    mz: float = defect_param(0.0, "-", "of Mz", (-0.5, 0.5))

    source = "thesis 3.1, hardware issue 19"
    touches = frozenset({"fx", "fz"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fx_true"})

    def install(self, site: Site) -> None:
        for k, error in enumerate((self.fx, self.fy, self.fz, self.mx, self.mz)):
            site.mix[k, k] += error


@dataclass(frozen=True)
class ForceLag(Defect):
    """The measurement amplifier filters the bridges.

    The filter is a first-order low-pass in time on all bridges.
    """

    time: float = defect_param(0.03, "s", "constant", (0.0, 5.0), "lag")

    source = "thesis 5.6: filtered by the measurement amplifier"
    touches = frozenset({"fx", "fz"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fx_true"})


@dataclass(frozen=True)
class ZeroDrift(Defect):
    """The zero of the bridges drifts with time.

    Each amplifier channel has an offset and a drift.
    """

    offset: tuple[float, ...] = defect_param(
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), "V", "of C1..C6", (-5.0, 5.0)
    )
    rate: tuple[float, ...] = defect_param(
        (1e-5, 2e-5, 2e-5, 0.0, 1e-5, 1e-5), "V/s", "of C1..C6", (-1.0, 1.0)
    )

    source = "thesis appendix C (offsets between runs)"
    touches = frozenset({"fx", "fy", "fz"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fx_true"})

    def install(self, site: Site) -> None:
        site.drift[:6, 0] += self.offset
        site.drift[:6, 1] += self.rate


@dataclass(frozen=True)
class SensorNoise(Defect):
    """White noise and resolution of the analogue inputs and of the drive's torque estimate. On by
    default.

    The noise is independent from sample to sample, and seeded.
    """

    bridge: float = defect_param(0.002, "V", "standard deviation at C1..C6", (0.0, 1.0))
    lvdt: float = defect_param(0.0005, "V", "standard deviation at the LVDT", (0.0, 1.0))
    torque: float = defect_param(
        0.01, "N m", "standard deviation of the reported motor torque", (0.0, 1.0)
    )
    adc_bits: int = defect_param(18, "bit", "resolution over both signs; 0: ideal", (0, 32))

    source = "thesis 3.1, hardware issue 6"
    touches = frozenset({"fx", "fy", "fz", "c4", "lvdt_volts"})
    spares = frozenset({"plank_counts", "wheel_counts", "motor_position"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["noise_bridge"], m["noise_lvdt"], m["noise_torque"] = self.bridge, self.lvdt, self.torque
        m["adc_step"] = 2.0 * m["volts_max"] / 2.0**self.adc_bits if self.adc_bits else 0.0


@dataclass(frozen=True)
class MainsHum(Defect):
    """Mains hum couples into the twelve metres of analogue cable. On by default.

    All bridges have the same sine; sampled at 250 Hz, 50 Hz is not aliased.
    """

    amplitude: float = defect_param(0.001, "V", "at C1..C6", (0.0, 1.0), "hum")
    frequency: float = defect_param(50.0, "Hz", "of the mains", (0.0, 1000.0), "hum_frequency")

    source = "thesis 3.1, hardware issue 6"
    touches = frozenset({"fx", "fy", "fz"})
    spares = frozenset({"lvdt_volts", "plank_counts", "wheel_counts", "motor_position"})


@dataclass(frozen=True)
class TimeSkew(Defect):
    """Forces and motion are recorded by two machines whose clocks differ.

    All bridges are delayed by a constant time relative to encoders and drive.
    """

    delay: float = defect_param(0.05, "s", "of the bridges", (0.0, 0.9), "skew")

    source = "thesis 3.2: two unsynchronised data sets"
    touches = frozenset({"fx", "fz"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fx_true"})


@dataclass(frozen=True)
class LvdtError(Defect):
    """The calibration of the LVDT is wrong.

    The axle height signal has errors of offset and gain.
    """

    offset: float = defect_param(0.02, "V", "at the LVDT", (-5.0, 5.0))
    gain: float = defect_param(0.01, "-", "relative", (-0.5, 0.5))

    source = "thesis 3.1, hardware issue 18"
    touches = frozenset({"lvdt_volts"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fx", "fy", "fz"})

    def install(self, site: Site) -> None:
        site.drift[6] += (self.offset, self.gain)
