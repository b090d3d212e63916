# SPDX-License-Identifier: Apache-2.0
"""Effects that are removed from the library together with all similar ones, and the right proposal
for each."""

from __future__ import annotations

from flatplank_validation.blind.menu import KIN
from flatplank_validation.proposed.forces import PLANK, Truth

SIGNAL, TRAVEL = ("signal",), ("motion", "signal")
WAVES = ("harmonic 1",)

LEFT_OUT: dict[str, Truth] = {
    "parasitic_force": Truth(SIGNAL, ("wheel angle",), ("",), WAVES),
    "nonuniformity_1": Truth(SIGNAL, ("wheel angle",), ("", "load"), WAVES),
    "runout_1": Truth(TRAVEL, ("wheel angle",), ("",), WAVES),
    "mesh_ripple": Truth(TRAVEL, (*PLANK, "pinion angle"), ("",), ("wave", "harmonic 1")),
    "worn_patch": Truth(
        ("friction",), ("plank position", "distance since the step"), ("",), ("bump",)
    ),
    "wear": Truth(("friction", "gain"), ("run order",), ("",), ("ramp", "power", "relaxation")),
    "zero_drift": Truth(SIGNAL, PLANK, ("",), ("ramp", "power")),
    "zero_drift_runs": Truth(SIGNAL, ("run order",), ("",), ("ramp", "power")),
    "drive_brake_asymmetry": Truth(
        ("gain", "friction"), ("",), ("driving", "braking"), ("constant",)
    ),
    "crosstalk_mx": Truth(SIGNAL, ("mx",), ("",), ("ramp",)),
    "carcass_pressure": Truth(("stiffness",), ("pressure",), ("",), ("ramp", "power", "step")),
}
PLAIN = ("drive_brake_asymmetry",)
"""effects that two amounts of slip cannot show: of the asymmetry a fit of the tire takes 99.6 %
there, and 86 % with the nine slips of the plain design"""
ALIKE: dict[str, tuple[str, ...]] = {
    "parasitic_force": ("nonuniformity_1", "runout_1", "crosstalk_fx_fz", "crosstalk_fz"),
    "nonuniformity_1": ("parasitic_force", "runout_1", "crosstalk_fx_fz", "crosstalk_fz"),
    "runout_1": ("parasitic_force", "nonuniformity_1", "crosstalk_fz", "measured_load"),
    "mesh_ripple": ("load_undulation",),
    "zero_drift": ("crosstalk_mx", "crosstalk_mz"),
    "wear": ("zero_drift_runs", "hub_gain"),
    "zero_drift_runs": ("wear",),
    "drive_brake_asymmetry": ("drive_brake_stiffness", "load_loss_braking", "slip_definition"),
    "crosstalk_mx": ("crosstalk_mz", "crosstalk_fy"),
}


def removed(name: str) -> set[str]:
    """Effects removed with `name`: its relatives in the answers, and similar effects."""
    return {name, *KIN.get(name, ()), *ALIKE.get(name, ())}
