# SPDX-License-Identifier: Apache-2.0
"""Appendices A, B, E, G, H and I; appendix C has a module of its own, D and F have no results."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from flatplank_analysis.figures import machine
from flatplank_analysis.figures.spec import Figure
from flatplank_analysis.report.table import Table
from flatplank_analysis.report.tables import magic_table
from flatplank_hw.hub import HubParameters
from flatplank_validation.thesis import chapter5_figures, rolling
from flatplank_validation.thesis.chapter5 import SPREAD, at_nominal
from flatplank_validation.thesis.chapter7 import BENT, vertical
from flatplank_validation.thesis.errors import MAGIC, rmse_rows
from flatplank_validation.thesis.lab import Lab
from flatplank_validation.thesis.published import (
    HALF_LENGTH,
    MAGIC_RMSE,
    NONLINEAR_RMSE,
    STIFFNESS,
    WHERE,
    table_i_1,
)
from flatplank_validation.thesis.registry import Chapter, Entry, Near, Row, Same, printed

SCREEN = "a picture of the software, no result; ours is the page of the panel"
FOOTPRINT = "a picture of ink on paper; the twin has no ink, and its contact length stands in G.4"
CONSTANTS = {
    "k_Fx1": ("k_fx1", 3.5841), "k_Fx2": ("k_fx2", 3.8158), "k_Fy": ("k_fy", 3.8246),
    "k_Fz1": ("k_fz1", 1.9775), "k_Fz2": ("k_fz2", 1.9396), "g": ("gravity", 9.81),
    "A_Fx": ("a_fx", 1000.0), "A_Fy": ("a_fy", 1000.0), "A_Fz": ("a_fz", 1000.0),
}  # fmt: skip
"""symbol -> parameter of the hub, value of Table A.1"""
LEVELS = {"NOMPRES", "FNOMIN", "LONGVL", "VXLOW", "WIDTH", "RIM_RADIUS", "FITTYP"}
"""keys of Table I.1 that are no result of a fit"""
DETERMINED = 3.0
"""a coefficient is compared where it is at least so many standard errors away from 0"""
WHY_COEFFICIENT = (
    "a coefficient of another tire; single coefficients are strongly correlated, the curves of "
    "figures 7.26 and 7.27 are not. Without a value of ours: these runs do not determine it, or "
    "it is not fitted; the table above says which"
)
RADIUS_LAW = (
    "the law of r_e has only C_z over pressure and leaves 0.2 mm between the two pressures, where "
    "starts scatter by 0.03 mm: the runs of one pressure alone determine it"
)
WHY = {
    "PFZ1": "Tables I.1 and 7.2 contradict each other: 0.8451 of Table 7.2 gives the 1.77·10⁵ N/m "
    "of 2 bar in Appendix G, 0.5243 gives 1.91·10⁵ N/m. Ours is that of Table 7.2, bent by the "
    "play of the rotation support",
    **dict.fromkeys(("BREFF", "DREFF", "FREFF"), RADIUS_LAW),
}
"""reasons of single coefficients"""


def _constant(name: str, _lab: Lab) -> float:
    return float(getattr(HubParameters(), name))


def _panel(axis: str, lab: Lab) -> Iterator[Figure]:
    """One panel of the figure of vertical stiffness, by the label of its x axis."""
    for f in machine.vertical(lab.matrix):
        panels = [p for p in f.panels if p.x_label.startswith(axis)]
        yield Figure(f.name, f.title, f.caption, panels)


def lengths(lab: Lab) -> Iterator[Figure]:
    yield from machine.contact_length(lab.matrix)


def half_length(fz: float, lab: Lab) -> float:
    """a at the nominal pressure [m]."""
    found = lab.matrix.extras["footprints"]
    here = (found["fz"] == fz) & (found["pressure"] == 2.5)
    return float(found["half_length"][here][0])


def window_difference(lab: Lab) -> str:
    """Whether loading lies above unloading in the fitted window."""
    runs = lab.matrix.extras["vertical_stiffness"]
    apart = [abs(r["loading"] / r["unloading"] - 1.0) for r in runs]
    return "two lines" if float(np.mean(apart)) > 0.005 else "one line"


def coefficient(name: str, lab: Lab) -> float:
    """A fitted coefficient; NaN where the data do not determine it."""
    fit = lab.matrix.magic
    found = None if fit is None else fit.estimates.get(name)
    if found is None or not found.determined:
        return math.nan
    return found.value


def table_i(lab: Lab) -> Table:
    """Table I.1: the thesis's Toyo beside ours, all coefficients."""
    ours = {str(row[0]): row for row in magic_table(lab.matrix).rows}
    rows = [
        [name, value, *(ours[name][1:] if name in ours else (math.nan, math.nan, "not fitted"))]
        for name, value in table_i_1().values.items()
        if name not in LEVELS
    ]
    header = ("coefficient", "thesis", "ours", "±", "remark")
    note = (
        "Ours fitted in stages, then jointly per output; a dash: nothing of these runs shows it."
    )
    return Table("table_i_1", "Coefficients of the Toyo", header, rows, note)


def _coefficients() -> Iterator[Row]:
    for name, value in table_i_1().values.items():
        if name in LEVELS or not value:
            continue
        digits = Near(0.05 * abs(value), "a relative error (7.28) ‘below 10 %’ of the curves: "
                      "half of it for a coefficient")  # fmt: skip
        yield Row(name, "", value, "Table I.1", partial(coefficient, name), digits,
                  WHY.get(name, WHY_COEFFICIENT))  # fmt: skip


A = Chapter(
    "A",
    "Appendix A: force and moment calculation",
    (
        Entry("A.1", "Drawing of the measurement hub", absent="a drawing"),
        Entry("A.2", "Forces and moments", absent="a diagram"),
        Entry("Table A.1", "Symbols of the calculation", None, tuple(
            Row(symbol, "m/s²" if symbol == "g" else "", value, "Table A.1",
                partial(_constant, name), printed(1e-4))
            for symbol, (name, value) in CONSTANTS.items()
        )),
    ),
)  # fmt: skip
B = Chapter(
    "B",
    "Appendix B: graphical user interface",
    tuple(Entry(f"B.{k}", "Picture of the interface", absent=SCREEN) for k in range(1, 5)),
)
E = Chapter(
    "E",
    "Appendix E: settling distance",
    (
        Entry("E.1", "Measured force and its exponential", chapter5_figures.exponential, (
            Row("settling distance", "m", 1.55, "Appendix E",
                partial(at_nominal, rolling.settling), SPREAD,
                "it follows from the friction torque of the twin, which is not the machine's"),
        )),
    ),
)  # fmt: skip
G = Chapter(
    "G",
    "Appendix G: contact patch and stiffness",
    (
        *(Entry(f"G.{k}", f"Footprint at {fz:g} N", absent=FOOTPRINT)
          for k, fz in enumerate(HALF_LENGTH, start=1)),
        Entry("G.4", "Half contact length over load", lengths, tuple(
            Row(f"a at {fz:g} N, 2.5 bar", "m", a, "(7.20) with Table 7.2",
                partial(half_length, fz), printed(0.0001))
            for fz, a in HALF_LENGTH.items()
        )),
        Entry("G.5", "Load over loaded radius", partial(_panel, "loaded"), (
            Row("loading and unloading", "", "two lines", "Appendix G", window_difference,
                Same(),
                "the tire of the plant has no hysteresis in its vertical stiffness"),
        )),
        Entry("G.6", "Vertical stiffness over pressure", partial(_panel, "pressure"), tuple(
            Row(f"C_z at {bar:g} bar", "N/m", value, "Appendix G", partial(vertical, bar),
                printed(1e3), BENT)
            for bar, value in STIFFNESS.items()
        )),
    ),
)  # fmt: skip
H = Chapter(
    "H",
    "Appendix H: RMSE values",
    tuple(
        Entry(f"Table H.{k}", title, None, tuple(
            row
            for label, values in printed_values.items()
            if label != "nominal"
            for row in rmse_rows(model, values, f"Table H.{k}", label=label, where=WHERE[label])
        ), note="The lines of the nominal point are Tables 7.3 and 7.4.")
        for k, title, model, printed_values in (
            (1, "RMSE of the nonlinear model", "nonlinear", NONLINEAR_RMSE),
            (2, "RMSE of MF-Tyre", MAGIC, MAGIC_RMSE),
        )
    ),
)  # fmt: skip
I = Chapter(  # noqa: E741
    "I",
    "Appendix I: MF-Tyre/MF-Swift parameters",
    (Entry("Table I.1", "Coefficients of the Toyo", None, tuple(_coefficients()), table_i,
           note="The Continental's column needs its matrix, which is not measured here."),),
)  # fmt: skip
