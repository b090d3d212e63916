# SPDX-License-Identifier: Apache-2.0
"""Words of tables: columns, numbers of the search on sweeps, coefficients of a tire file."""

from __future__ import annotations

import re
from collections.abc import Mapping

from flatplank_analysis.word import Word
from flatplank_tire.magic_formula.coefficients import SECTION_OF

COLUMNS: Mapping[str, Word] = {
    # what was measured
    "measurement": Word(
        "kind of measurement", "What a run measures: slip step, free rolling, cleat, parking."
    ),
    "run": Word("run", "One measurement: one bag or one table."),
    "runs": Word("number of runs", "Runs of the condition, repeats included."),
    "starts": Word(
        "starts", "Wheel angles at the begin of the runs: 1, 2, 3 for 0, 120, 240 deg."
    ),
    "lost": Word("lost cycles", "Cycles of the bus that have no sample."),
    "cycles lost": Word("lost cycles", "Cycles of the bus that have no sample."),
    "of": Word("cycles of the run", "Cycles that the recording should have."),
    "longest": Word("longest gap", "Time of the longest stretch without a sample.", "s"),
    "road": Word("road of the longest gap", "Way of the plank in that stretch.", "mm"),
    "used": Word("used", "Whether the run is evaluated."),
    "Fz": Word("load", "Vertical force on the tire.", "N", "Fz"),
    "p [bar]": Word("inflation pressure", "Pressure in the tire.", "bar", "p"),
    "pressure": Word("inflation pressure", "Pressure in the tire.", "bar", "p"),
    "alpha": Word("side slip angle", "Angle between wheel plane and travel, ISO W.", "deg", "α"),
    "gamma": Word("camber", "Inclination of the wheel, ISO W.", "deg", "γ"),
    "camber": Word("camber", "Inclination of the wheel, ISO W.", "deg", "γ"),
    "speed": Word("speed", "Speed of the road below the tire.", "m/s", "V"),
    "Fx": Word("longitudinal force", "Force of the road on the tire, forward.", "N", "Fx"),
    "Fy": Word("side force", "Force of the road on the tire, to the left.", "N", "Fy"),
    # steps
    "κ desired": Word("desired slip", "Slip that the plan asks for.", "%", "κ"),
    "κ before": Word("slip before the step", "Slip as measured before the step.", "%", "κ"),
    "κ actual": Word("slip after the step", "Slip as measured after the step.", "%", "κ"),
    "ΔFz": Word("change of load", "Change of the load by the step, over the load.", "%", "ΔFz"),
    "V before": Word("speed before the step", "Speed of the road before the step.", "mm/s", "V"),
    "V after": Word("speed after the step", "Speed of the road after the step.", "mm/s", "V"),
    "largest std of Fx": Word(
        "scatter", "Largest standard deviation of Fx between the runs of a condition.", "N"
    ),
    "settled": Word("settled", "Whether the force had its end value within the run."),
    # estimates
    "value": Word("value", "Number that was fitted; in parentheses: not determined."),
    "±": Word("standard error", "Standard deviation of the number in the same unit."),
    "± of that": Word("standard error", "Standard deviation of the number in the same unit."),
    "unit": Word("unit", "Unit of value and error; - is that of a plain factor."),
    "remark": Word("remark", "Reservation about the numbers of the row."),
    "at bound": Word("at bound", "Which end of its range a number rests on."),
    "from": Word("source", "Where a number comes from."),
    "source": Word("source", "Where a number comes from."),
    "parameter": Word("parameter", "Name of a number that is fitted."),
    "coefficient": Word("coefficient", "Name of a number in a tire file."),
    "output": Word("output", "Force or moment that a tire file predicts."),
    "quantity": Word("quantity", "What the value of the row measures."),
    "σx (7.27)": Word("relaxation length", "That of the fitted carcass at zero slip.", "m", "σx"),
    "σx": Word("relaxation length", "Road over which Fx follows a step of the slip.", "m", "σx"),
    "σx without it": Word("relaxation length", "Without the bias of the model.", "m", "σx"),
    "C′Fκ": Word("secant slip stiffness", "Steady Fx of a step over its slip.", "kN", "C′Fκ"),
    "CFκ": Word("slip stiffness", "Slope of Fx over the slip at zero slip.", "kN", "CFκ"),
    "Fx,ss": Word("steady force", "Fx at the end of the transient.", "N", "Fx,ss"),
    "corr(σ, F)": Word(
        "correlation", "Between the errors of relaxation length and steady force.", "-"
    ),
    "RMSE": Word("error", "Root mean square of measurement minus model.", "N", "RMSE"),
    "c_cx": Word("carcass stiffness", "Stiffness of the carcass along the road.", "kN/m", "c_cx"),
    "c_cx without it": Word("carcass stiffness", "Without the bias of the model.", "kN/m", "c_cx"),
    "model's bias of c_cx": Word(
        "bias of the model", "What the model finds too much on a tread of bristles.", "%"
    ),
    "of σx": Word("bias of the model", "The same for the relaxation length.", "%"),
    "a": Word("half contact length", "Half the length of the contact patch.", "mm", "a"),
    "e_r": Word("relative error", "Error over the largest output (7.28).", "%", "e_r"),
    "R2": Word("share explained", "1: the model explains all that varies.", "-", "R²"),
    # rolling and machine
    "r_e at Fx = 0": Word("effective rolling radius", "That of a wheel without Fx.", "mm", "r_e"),
    "reference": Word("reference", "Force that the controller holds.", "N"),
    "settling distance": Word("settling distance", "Road until Fx stays within 5 %.", "m"),
    "asymptote p3": Word("asymptote", "End value of the exponential fit (E.1).", "N", "p3"),
    "steady Fx": Word("steady force", "Mean of Fx over the last 1.5 m.", "N"),
    "steady error": Word("steady error", "Steady force beside the reference.", "%"),
    "C_x at rest": Word("stiffness at rest", "Fx over the way of a standing tire.", "kN/m", "C_x"),
    "C_x rolling": Word("rolling stiffness", "Slip stiffness over relaxation length.", "kN/m"),
    "rest / rolling": Word("ratio", "Stiffness at rest over the rolling one.", "-"),
    "M_M": Word("motor torque", "Torque of the motor at the wheel drive.", "N m", "M_M"),
    "M_T / i": Word("tire torque", "Torque of the tire over the gear ratio.", "N m", "M_T / i"),
    "M_F": Word("friction torque", "Torque of the unloaded drive.", "N m", "M_F"),
    "η": Word("efficiency", "Torque at the tire over that of the motor (5.3).", "%", "η"),
    # diagnosis
    "effect": Word("effect", "A physical cause that the model may lack."),
    "size": Word("size", "Fitted size of an effect, in the unit of its main parameter."),
    "why": Word("why", "What speaks against an effect that was refused."),
    "over": Word("over", "Coordinate along which something is left."),
    "where": Word("where", "Place on that coordinate, or condition."),
    "level": Word("level", "Mean residual of the place.", "N"),
    "in": Word("in", "Conditions that show it."),
    # sweeps
    "swept": Word("swept slip", "Slip angle or slip that the file sweeps."),
    "samples": Word("samples", "Number of samples of the condition."),
    "B": Word("stiffness factor", "Of the Magic Formula of one sweep.", "-", "B"),
    "C": Word("shape factor", "Of the Magic Formula of one sweep.", "-", "C"),
    "D": Word("peak value", "Of the Magic Formula of one sweep.", "N", "D"),
    "E": Word("curvature factor", "Of the Magic Formula of one sweep.", "-", "E"),
    "BCD": Word("slope", "Slope of the force at zero slip.", "N/deg", "BCD"),
    "rms": Word("scatter", "Root mean square of the sweep beside its own formula.", "N"),
    "of the largest force": Word("relative error", "Error over the largest force.", "%"),
    "of the largest moment": Word("relative error", "Error over the largest moment.", "%"),
    "chance": Word("chance", "That scatter alone makes an error as large.", "-"),
    "off most": Word("off most", "Largest difference between file and sweep, and its slip."),
    "force": Word("force", "Fx, Fy, or the moment Mz."),
}
"""headers of tables, without the unit in brackets"""

SWEEPS: Mapping[str, Word] = {
    "grip": Word("friction", "Factor on the friction of the tire file.", "1"),
    "stiffness": Word("slip stiffness", "Factor on the slope of the tire file at zero slip.", "1"),
    "curvature": Word("curvature", "Change of E of the tire file.", "1"),
    "grip_load": Word("friction over load", "Change for each nominal load.", "1"),
    "stiffness_load": Word("slip stiffness over load", "Change for each nominal load.", "1"),
    "curvature_load": Word("curvature over load", "Change of E for each nominal load.", "1"),
    "distance": Word("distance", "Road that the tire has rolled in the file.", "m"),
    "fz": Word("load", "Vertical force on the tire.", "N"),
    "temperature": Word("temperature", "Temperature of the tread.", "K"),
    "rate": Word("rate of the slip", "How fast the slip angle or slip is swept.", "rad/s"),
}
"""parameters and coordinates of the search on sweeps, beside those of steps"""

_PARTS = {"P": "pure slip", "R": "combined slip", "Q": "moments"}
_FACTORS = {
    "B": "stiffness factor", "C": "shape factor", "D": "peak", "E": "curvature",
    "K": "slip stiffness", "H": "horizontal shift", "V": "vertical shift",
    "P": "influence of the pressure", "S": "moment", "T": "relaxation length",
}  # fmt: skip
_OUTPUTS = {"X": "Fx", "Y": "Fy", "Z": "Mz"}
_COEFFICIENT = re.compile(r"([PRQ])([BCDEKHVPST])([XYZ])(\d+)")


def coefficient(name: str) -> Word | None:
    """The word of a coefficient of the Magic Formula by the parts of its name; None for others."""
    if name not in SECTION_OF:
        return None
    parts = _COEFFICIENT.fullmatch(name)
    section = SECTION_OF[name].replace("_", " ").lower()
    if not parts:
        return Word(f"entry of the section {section}", "A number of the tire file.", "-", name)
    part, factor, output, number = parts.groups()
    title = f"{_FACTORS[factor]} of {_OUTPUTS[output]}, coefficient {number}"
    sentence = f"Of the Magic Formula, {_PARTS[part]}; section {section} of the tire file."
    return Word(title, sentence, "-", name)
