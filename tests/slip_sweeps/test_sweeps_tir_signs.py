# SPDX-License-Identifier: Apache-2.0
"""A tire file that was fitted under other signs is told with the flag that reads it so, and is
never taken so silently."""

from __future__ import annotations

import json
import math

import formula_of_sweeps as tire
import numpy as np
import pytest

import flatplank_analysis as fp
from flatplank_analysis.cli.main import main
from flatplank_analysis.slip_sweeps.tir_signs import CONVENTIONS, errors_of, likelier, side_of
from flatplank_tire.tir import parse_tir

SHIFT = 0.01
"""PHY1 of the files: a plysteer [rad]"""
FILES = {
    "iso": {},
    "mirrored": {"PHY1": -SHIFT},
    "sae": {"PHY1": -SHIFT, "PKY6": -tire.P["PKY6"]},
    "adapted": {"PKY1": -tire.P["PKY1"], "PKY6": -tire.P["PKY6"]},
    "camber": {"PKY6": -tire.P["PKY6"]},
    "alpha": {"PHY1": -SHIFT, "PKY1": -tire.P["PKY1"]},
    "adapted_mirrored": {"PHY1": -SHIFT, "PKY1": -tire.P["PKY1"], "PKY6": -tire.P["PKY6"]},
    "adapted_camber": {"PKY1": -tire.P["PKY1"]},
}
"""the same tire under each convention: what changes in the coefficients"""


def files(folder, changes, side=None):
    """Sweeps of a tire with plysteer and camber thrust, and its file with changes."""
    columns = tire.sweep(tire.wave(240), (-3.0, 0.0, 3.0))
    shifted = tire.side_force(columns["FZ"], columns["SA"] + SHIFT, columns["IA"])
    columns["FY"] += shifted - tire.side_force(columns["FZ"], columns["SA"], columns["IA"])
    path, tir = tire.files(folder, tire.text_of(columns))
    text = tir.read_text()
    for key, value in ({"PHY1": SHIFT} | changes).items():
        if key in tire.P:
            text = text.replace(f"{key} = {tire.P[key]}\n", f"{key} = {value}\n")
        else:
            text += f"{key} = {value}\n"
    if side:
        text = text.replace("[MODEL]\n", f"[MODEL]\nTYRESIDE = '{side}'\n")
    tir.write_text(text)
    return path, tir


@pytest.mark.parametrize("name", FILES)
def test_the_signs_that_fit_are_told_and_read_on_demand(name, tmp_path, capsys):
    path, tir = files(tmp_path, FILES[name], side="RIGHT")
    assert main(["sweeps", str(path), "--tir", str(tir)]) == 0
    text = capsys.readouterr().out
    assert ("the file may have been fitted so" in text) == (name != "iso")
    if name == "iso":
        return
    assert f"(--tir-signs {name})" in text and "TYRESIDE RIGHT" in text
    told = fp.sweeps(path).compare(tir, signs=name)
    assert told.error.max() < 3.0 * tire.NOISE
    assert told.attrs["tir_signs"]["used"] == name and not told.attrs["tir_signs"]["likelier"]
    assert main(["sweeps", str(path), "--tir", str(tir), "--tir-signs", name, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert max(c["error"] for c in found["conditions"]) == pytest.approx(told.error.max())
    errors = found["tir_signs"]["errors"]
    assert errors[name] < 0.5 * errors["iso"] and len(errors) == len(FILES)


def test_conventions_that_fit_alike_are_all_told(tmp_path):
    """Without camber nothing tells a mirrored file from one in the numbers of SAE."""
    columns = tire.sweep(tire.wave(240))
    columns["FY"] = tire.side_force(columns["FZ"], columns["SA"] + SHIFT, columns["IA"])
    path, tir = tire.files(tmp_path, tire.text_of(columns))
    tir.write_text(f"{tir.read_text()}PHY1 = {-SHIFT}\n")
    told = fp.sweeps(path).compare(tir).attrs["tir_signs"]
    assert told["likelier"] == ["mirrored", "sae"]


def test_a_bad_file_is_not_excused_by_signs(tmp_path, capsys):
    """A grip that is 20 % too low."""
    path, tir = files(tmp_path, {"PDY1": 0.8 * tire.P["PDY1"]})
    assert main(["sweeps", str(path), "--tir", str(tir)]) == 0
    assert "may have been fitted so" not in capsys.readouterr().out


def test_an_unknown_convention_is_one_line(tmp_path, capsys):
    path, tir = files(tmp_path, {})
    with pytest.raises(fp.FlatplankError, match="no convention 'miror'.*nearest is 'mirrored'"):
        fp.sweeps(path).compare(tir, signs="miror")
    assert main(["sweeps", str(path), "--tir-signs", "sae"]) == 1
    assert "give --tir FILE" in capsys.readouterr().err
    assert math.isfinite(fp.sweeps(path).compare(tir).error.max())


def test_the_error_of_a_convention_is_the_root_mean_square_over_the_conditions():
    each = {signs: np.array([3.0, 4.0]) * (k + 1) for k, signs in enumerate(CONVENTIONS.values())}
    found = errors_of(lambda signs: list(each[signs]))
    assert found == pytest.approx(
        {name: (k + 1) * math.sqrt(12.5) for k, name in enumerate(CONVENTIONS)}
    )


@pytest.mark.parametrize(
    ("errors", "used", "found"),
    [
        ({"iso": 10.0, "sae": 4.9, "alpha": 7.0}, "iso", ["sae"]),
        ({"iso": 10.0, "sae": 5.1, "alpha": 7.0}, "iso", []),
        ({"iso": 10.0, "sae": 5.0, "alpha": 5.0}, "iso", []),
        ({"iso": 10.0, "sae": 1.0, "alpha": 1.0}, "iso", ["sae", "alpha"]),
        ({"iso": 10.0, "sae": 1.0, "alpha": 1.0}, "sae", []),
        ({"iso": 0.5, "sae": 2.0, "alpha": 3.0}, "sae", ["iso"]),
        ({"iso": 0.3, "sae": 0.5, "alpha": 3.0}, "sae", []),
        ({"iso": 1.0}, "iso", []),
    ],
)
def test_another_convention_is_told_when_it_halves_the_error(errors, used, found):
    assert likelier(errors, used) == found


@pytest.mark.parametrize(
    ("entry", "side"),
    [("TYRESIDE = 'left'", "LEFT"), ('TYRESIDE = " Right "', "RIGHT"), ("", ""),
     ("TYRESIDE = LEFT", "LEFT")],
)  # fmt: skip
def test_the_side_that_a_file_states(entry, side):
    assert side_of(parse_tir(tire.TIR.replace("[MODEL]\n", f"[MODEL]\n{entry}\n"), "t")) == side
