# SPDX-License-Identifier: Apache-2.0
"""Sweeps as other rigs write them: the curves of the formula, or a refusal with the reason."""

from __future__ import annotations

import formula_of_sweeps as tire
import numpy as np
import pytest

from flatplank_analysis.slip_sweeps.study import study
from flatplank_data.errors import FlatplankError

POUND = 4.4482216152605
WAVE = tire.sweep(tire.wave(480))
CAMBERED = tire.sweep(tire.wave(480), gammas=(0.0, 4.0))


def in_pounds(moment: str, force: str = "lb") -> str:
    small = {k: v / POUND if k in ("FZ", "FY") else v for k, v in WAVE.items()}
    return tire.text_of(small, {"FZ": force, "FY": force, "MZ": moment})


def in_order(rows: np.ndarray, without: str = "") -> str:
    return tire.text_of({k: v[rows] for k, v in WAVE.items() if k != without})


def with_cells(name: str, rows: range, cell: str) -> str:
    lines = tire.text_of(WAVE).split("\n")
    at = lines[0].split(",").index(name)
    for row in rows:
        cells = lines[row + 2].split(",")
        lines[row + 2] = ",".join([*cells[:at], cell, *cells[at + 1 :]])
    return "\n".join(lines)


def turned(*names: str) -> str:
    return tire.text_of({k: -v if k in names else v for k, v in CAMBERED.items()})


N = len(WAVE["ET"])
READ = {
    "lbf, lbf-ft": in_pounds("lbf-ft", "lbf"),
    "pounds, in-lb": in_pounds("in-lb", "pounds"),
    "LBS, FT*LB": in_pounds("FT*LB", "LBS"),
    "kN": tire.text_of({k: v / 1e3 if k in ("FZ", "FY") else v for k, v in WAVE.items()},
                       {"FZ": "kN", "FY": "kN"}),
    "steps of 1.5 deg": tire.text_of(tire.sweep(tire.stairs(1.5))),
    "quantised by 1 deg": tire.text_of(tire.sweep(np.round(tire.wave(480)))),
    "quantised by 0.25 deg": tire.text_of(tire.sweep(0.25 * np.round(tire.wave(480) / 0.25))),
    "one way only": tire.text_of(tire.sweep(np.linspace(-12.0, 12.0, 480))),
    "sorted by load": in_order(np.argsort(WAVE["FZ"], kind="stable")),
    "reversed": in_order(np.arange(N)[::-1]),
    "shuffled": in_order(np.random.default_rng(1).permutation(N)),
    "OVL at the end": with_cells("MZ", range(N - 480, N), "OVL"),
    "text as camber": with_cells("IA", range(N), "--"),
    "gaps in the load": with_cells("FZ", range(100, 110), "OVL"),
    "two points in a slip": with_cells("SA", range(100, 105), "1.2.3"),
    "semicolons, decimal comma": tire.text_of(WAVE).replace(",", ";").replace(".", ","),
}  # fmt: skip
AXES = {
    "SAE": ("SA", "FY", "FZ"), "adapted": ("FY",), "ISO, alpha turned": ("SA",),
    "ISO, camber turned": ("IA",), "SAE, camber turned": ("SA", "FY", "FZ", "IA"),
}  # fmt: skip
REFUSED = {
    "Fy in kN that says N": (tire.text_of({**WAVE, "FY": WAVE["FY"] / 1e3}), "goes up to 2.8"),
    "Fz in kN that says N": (tire.text_of({**WAVE, "FZ": WAVE["FZ"] / 1e3}), "at a load of 1.2 N"),
    "an unknown unit": (in_pounds("ft-lb", "klbf"), "unknown unit 'klbf'"),
    "sorted by slip without stamps": (
        in_order(np.argsort(WAVE["SA"], kind="stable"), "ET"), "the load changes from row to row"),
    "shuffled without stamps": (
        in_order(np.random.default_rng(1).permutation(N), "ET"), "sort the rows by time"),
}  # fmt: skip


def formula_comes_back(found, conditions: int) -> None:
    assert len(found.conditions) == conditions
    for condition, formula in zip(found.conditions, found.formulas, strict=True):
        if condition.held.get("gamma", 0.0) == pytest.approx(0.0, abs=0.01):
            fz = condition.held["fz"]
            assert abs(formula.values["D"]) == pytest.approx(tire.peak(fz), rel=0.02)
            assert formula.stiffness == pytest.approx(tire.stiffness(fz), rel=0.02)


@pytest.mark.parametrize("case", READ)
def test_every_way_of_writing_gives_the_formula(case, tmp_path):
    formula_comes_back(study(tire.files(tmp_path, READ[case])[0]), 3)


@pytest.mark.parametrize("case", AXES)
def test_every_way_of_counting_gives_the_formula(case, tmp_path):
    found = study(tire.files(tmp_path, turned(*AXES[case]))[0])
    formula_comes_back(found, 6)
    assert ("the other way" in found.said[0]) == ("turned" in case)


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_read_for_sure_is_refused_with_its_reason(case, tmp_path):
    text, words = REFUSED[case]
    with pytest.raises(FlatplankError) as caught:
        study(tire.files(tmp_path, text)[0])
    assert words in str(caught.value) and "\n" not in str(caught.value)
