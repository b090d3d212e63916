# SPDX-License-Identifier: Apache-2.0
"""Remarks on a tire property file: each stands there for its reason, and goes with it."""

from __future__ import annotations

import pytest

from flatplank_tire.magic_formula import DEFAULTS, SECTION_OF
from flatplank_tire.tir import LISTED, parse_tir, shipped_tir

WHOLE = {k: 0.1 for k, section in SECTION_OF.items() if section in LISTED} | {
    "LONGITUDINAL_STIFFNESS": 2e5, "LATERAL_STIFFNESS": 1e5, "VXLOW": 0.0,
}  # fmt: skip
OF_OLD = ("LGAX", "LGAY", "LGAZ", "LSGKP", "LSGAL", "PTX1", "PTX2", "PTX3", "PTY1", "PTY2", "PHY3")
TIR = shipped_tir().replaced({k: v for k, v in WHOLE.items() if k not in OF_OLD})


def told(**values) -> list[str]:
    return TIR.replaced(values).warnings(vx=-0.03)


def test_a_file_that_says_all_has_no_remark():
    assert told() == []


@pytest.mark.parametrize(
    ("values", "remark"),
    [
        ({"VXLOW": 0.04}, "VXLOW = 0.04 m/s is above the speed of 0.03 m/s"),
        ({"PKY2": 0.0}, "PKY2 = 0: the load of the largest cornering stiffness"),
        ({"PCX1": 0.0, "PKX1": 0.0}, "PCX1, PKX1 = 0: Fx is zero but for its shifts"),
        ({"PDY1": 0.0}, "PDY1 = 0: Fy is zero but for its shifts"),
        ({"LONGITUDINAL_STIFFNESS": 0.0}, "LONGITUDINAL_STIFFNESS is missing: sigma_x"),
        ({"LATERAL_STIFFNESS": -1.0}, "LATERAL_STIFFNESS is missing: sigma_y is not known"),
        ({"VERTICAL_STIFFNESS": float("nan")}, "VERTICAL_STIFFNESS is missing: R_e and the"),
        ({"Q_RA1": 0.0, "Q_RA2": 0.0}, "Q_RA1 and Q_RA2 are missing: the contact length"),
        ({"RBX1": 0.0, "RBY1": 0.0}, "RBX1 and RBY1 are missing: combined slip"),
        ({"PHY3": 0.1, "LGAX": 1.0}, "Magic Formula 6.1 has no PHY3: not used; write FITTYP = 6 "),
    ],
)
def test_one_lack_is_one_remark(values, remark):
    (said,) = told(**values)
    assert said.startswith(remark)


@pytest.mark.parametrize(
    "values",
    [{"VXLOW": 0.03}, {"Q_RA1": 0.0}, {"Q_RA2": 0.0}, {"RBX1": 0.0}, {"RBY1": 0.0},
     {"LONGITUDINAL_STIFFNESS": 1.0}, {"PHY3": DEFAULTS["PHY3"]}],
)  # fmt: skip
def test_what_is_no_lack_has_no_remark(values):
    assert told(**values) == []


def test_remarks_on_what_stands_in_the_text():
    text = "[UNITS]\nANGLE = 'Degree'\nFORCE = 'kN'\nLENGTH = 'm'\n[MODEL]\nVXLOW = 0\n"
    said = parse_tir("MYKEY = 3\nPKX1 = 4\n" + text).warnings()
    assert "ANGLE is in degrees: coefficients are per radian" in " | ".join(said)
    assert "converted to SI from FORCE kN" in said
    for name, length in (("LONGITUDINAL", "sigma_x"), ("LATERAL", "sigma_y")):
        assert f"{name}_STIFFNESS is missing: {length} is not known" in said
    own = parse_tir("[LATERAL_COEFFICIENTS]\nPTX1 = 2\nPTY1 = 2\n[MODEL]\nFITTYP = 6\n")
    assert not any("sigma" in s for s in own.warnings())
    assert "FITTYP is missing: taken as Magic Formula 6.1" in said
    assert "keys before the first section are kept but not used: MYKEY" in said
    absent = next(s for s in said if s.startswith("not in the file"))
    names = absent.rpartition(": ")[2].split(", ")
    wanted = [k for k in DEFAULTS if SECTION_OF[k] in LISTED and k not in OF_OLD and k != "PKX1"]
    assert names == wanted
    assert not any("ANGLE" in s for s in parse_tir("[UNITS]\nANGLE = 'radians'").warnings())
