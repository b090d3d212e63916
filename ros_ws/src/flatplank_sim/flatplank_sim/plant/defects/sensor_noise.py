# SPDX-License-Identifier: Apache-2.0
"""White noise and resolution of the analogue inputs and of the drive's torque estimate. On by
default.
"""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("sensor_noise")
@dataclass(frozen=True)
class SensorNoise(Defect):
    """Each sample alone; seeded."""

    bridge: float = size(0.002, "V", "standard deviation at C1..C6", (0.0, 1.0))
    lvdt: float = size(0.0005, "V", "standard deviation at the LVDT", (0.0, 1.0))
    torque: float = size(
        0.01, "N m", "standard deviation of the reported motor torque", (0.0, 1.0)
    )
    adc_bits: int = size(18, "bit", "resolution over both signs; 0: ideal", (0, 32))

    source = "thesis 3.1, hardware issue 6"
    touches = frozenset({"fx", "fy", "fz", "c4", "lvdt_volts"})
    spares = frozenset({"plank_counts", "wheel_counts", "motor_position"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["noise_bridge"], m["noise_lvdt"], m["noise_torque"] = self.bridge, self.lvdt, self.torque
        m["adc_step"] = 2.0 * m["volts_max"] / 2.0**self.adc_bits if self.adc_bits else 0.0
