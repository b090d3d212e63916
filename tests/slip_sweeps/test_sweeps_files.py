# SPDX-License-Identifier: Apache-2.0
"""Files of sweeps as rigs and people write them: the formula comes back, and losses are told."""

from __future__ import annotations

import formula_of_sweeps as tire
import h5py
import numpy as np
import pytest

from flatplank_analysis.cli.main import main
from flatplank_analysis.slip_sweeps.study import study
from flatplank_data.errors import FlatplankError
from flatplank_tire.tir import read_tir
from flatplank_tire.tydex import Channel, Quantity, TydexFile, format_tydex
from flatplank_validation.trust.files.matlab73 import write_mat73

UNLIKELY = 1e-4
"""chance that the scatter of one of the conditions here, some sixty, is never seen to have"""


def agrees(found, conditions: int = 3) -> None:
    """The curves of a study are those of the formula."""
    assert len(found.conditions) == conditions
    loads = {round(c.held["fz"]) for c in found.conditions}
    assert loads == set(tire.LOADS)
    for condition, formula in zip(found.conditions, found.formulas, strict=True):
        fz = condition.held["fz"]
        assert abs(formula.values["D"]) == pytest.approx(tire.peak(fz), rel=0.02)
        assert formula.stiffness == pytest.approx(tire.stiffness(fz), rel=0.02)


def exact(found, tir) -> None:
    """The errors of the exact tire file are no more than scatter."""
    assert 0.0 < max(curve.floor for curve in found.curves) < tire.NOISE
    assert min(f.chance for f in found.failures(read_tir(str(tir)))) > UNLIKELY


SLIPS = {
    "a sine": tire.wave(480),
    "steps of 1 deg": tire.stairs(1.0),
    "steps of 2 deg": tire.stairs(2.0, 12),
    "steps of 0.7 deg": tire.stairs(0.7, 4),
    "quantised by 0.4 deg": 0.4 * np.round(tire.wave(480) / 0.4),
    "quantised by 0.8 deg": 0.8 * np.round(tire.wave(480) / 0.8),
    "quantised by 0.1 deg": 0.1 * np.round(tire.wave(480) / 0.1),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_held_and_quantised_slip_gives_the_curve_and_the_exact_file_is_right(slip, tmp_path):
    path, tir = tire.files(tmp_path, tire.text_of(tire.sweep(SLIPS[slip])))
    found = study(path)
    agrees(found)
    exact(found, tir)


def test_bins_have_the_mean_slip_of_their_samples(tmp_path):
    path, _ = tire.files(tmp_path, tire.text_of(tire.sweep(tire.stairs(2.0, 12))))
    for curve in study(path).curves:
        filled = np.degrees(curve.slip[np.isfinite(curve.slip)])
        assert filled == pytest.approx(np.arange(-12.0, 13.0, 2.0), abs=1e-5)


ANGLES = {
    "ISO": ((), "ISO W", "by Fz"),
    "ISO, slip angle turned": (("SA",), "ISO W", "the slip angle is counted the other way"),
    "ISO, camber turned": (("IA",), "ISO W", "the camber is counted the other way"),
    "SAE": (("SA", "FY", "FZ", "MZ"), "SAE J670", "by Fz"),
    "SAE, slip angle turned": (("FY", "FZ", "MZ"), "SAE J670", "the slip angle is counted"),
    "SAE, camber turned": (("SA", "IA", "FY", "FZ", "MZ"), "SAE J670", "the camber is counted"),
    "adapted SAE": (("FY", "MZ"), "adapted SAE", "by Fz"),
}


@pytest.mark.parametrize("case", ANGLES)
def test_the_camber_thrust_tells_which_angle_is_turned(case, tmp_path):
    turned, title, words = ANGLES[case]
    columns = {k: -v if k in turned else v for k, v in tire.sweep(tire.wave(), (0.0, 4.0)).items()}
    path, tir = tire.files(tmp_path, tire.text_of(columns))
    found = study(path)
    assert title in found.said[0] and words in found.said[0]
    agrees(found, 6)
    exact(found, tir)


def test_a_channel_is_turned_as_asked_for(tmp_path, capsys):
    columns = tire.sweep(tire.wave())
    path, tir = tire.files(tmp_path, tire.text_of(columns | {"SA": -columns["SA"]}))
    assert "adapted SAE" in study(path).said[0]  # without camber nothing tells the two apart
    with pytest.raises(FlatplankError, match="--turn the channel"):
        study(path, "iso")
    found = study(path, "iso", ["alpha"])
    agrees(found)
    exact(found, tir)
    assert main(["sweeps", str(path), "--axes", "iso", "--turn", "alpha"]) == 0
    assert "turned as asked for: alpha" in capsys.readouterr().out
    with pytest.raises(FlatplankError, match="no channel 'beta' to turn"):
        study(path, "iso", ["beta"])


def cell(text: str, name: str, chosen) -> str:
    """The file with a text in a column of the samples chosen by their index."""
    lines = text.splitlines()
    at = lines[0].split(",").index(name)
    for k in range(2, len(lines)):
        if chosen(k - 2):
            cells = lines[k].split(",")
            cells[at] = "OVL"
            lines[k] = ",".join(cells)
    return "\n".join(lines)


N = len(tire.wave())


@pytest.mark.parametrize("name", ["MZ", "ET"])
def test_text_in_a_channel_that_is_not_needed_costs_no_row(name, tmp_path):
    text = cell(tire.text_of(tire.sweep(tire.wave())), name, lambda k: k // N % 3 == 2)
    if name == "ET":
        text = text.replace("ET", "Clock", 1)
    found = study(tire.files(tmp_path, text)[0])
    agrees(found)
    assert len(found.columns["fz"]) == 6 * N
    assert any(f"{2 * N} of {6 * N} cells are not numbers" in line for line in found.said)
    assert any(f"'OVL' in line {2 * N + 3}" in line for line in found.said)


def test_a_further_column_of_text_costs_nothing(tmp_path):
    columns = tire.sweep(tire.wave())
    rows = tire.text_of(columns).splitlines()
    text = "\n".join(f"{row},{extra}" for row, extra in zip(
        rows, ["note", "-", *("ok" for _ in rows[2:])], strict=True))  # fmt: skip
    found = study(tire.files(tmp_path, text)[0])
    agrees(found)
    assert "column 'note' is text and was left out" in found.said


@pytest.mark.parametrize(("name", "what"), [("FY", "have no Fy"), ("FZ", "are left out")])
def test_rows_without_a_needed_number_are_counted_and_quoted(name, what, tmp_path):
    text = cell(tire.text_of(tire.sweep(tire.wave())), name, lambda k: k % 10 == 5)
    found = study(tire.files(tmp_path, text)[0])
    agrees(found)
    lost = 6 * N // 10
    (told,) = [line for line in found.said if what in line]
    assert told.startswith(f"{lost} of {6 * N} samples") and "'OVL' in line 8" in told
    assert sum(len(c.samples) for c in found.conditions) == 6 * N - lost


def test_rows_in_another_order_are_those_in_order_of_time(tmp_path):
    columns = tire.sweep(tire.wave(), (0.0, 4.0))
    in_order = study(tire.files(tmp_path, tire.text_of(columns))[0])
    ways = {
        "by slip": np.argsort(columns["SA"], kind="stable"),
        "by load": np.argsort(columns["FZ"], kind="stable"),
        "backward": np.arange(len(columns["SA"]))[::-1],
        "shuffled": np.random.default_rng(2).permutation(len(columns["SA"])),
    }
    for name, rows in ways.items():
        text = tire.text_of({k: v[rows] for k, v in columns.items()})
        found = study(tire.files(tmp_path, text)[0])
        assert "rows are not in order of time: sorted by their stamps" in found.said, name
        for one, other in zip(found.conditions, in_order.conditions, strict=True):
            assert one.label == other.label
            np.testing.assert_array_equal(one.samples, other.samples)
        assert [c.floor for c in found.curves] == [c.floor for c in in_order.curves]


def test_several_recordings_in_a_file_stay_in_their_order(tmp_path):
    columns = tire.sweep(tire.wave())
    half = len(columns["ET"]) // 2
    columns["ET"] = np.concatenate([columns["ET"][:half]] * 2)
    found = study(tire.files(tmp_path, tire.text_of(columns))[0])
    agrees(found)
    assert "2 recordings follow one another: the time starts again" in found.said


def test_stamps_that_tell_no_order_are_refused(tmp_path):
    columns = tire.sweep(tire.wave())
    columns["ET"] = np.random.default_rng(2).integers(0, 50, len(columns["ET"])).astype(float)
    with pytest.raises(FlatplankError, match="time does not increase"):
        study(tire.files(tmp_path, tire.text_of(columns))[0])


US = {"FZ": ("lb", 4.4482216152605), "FY": ("lbf", 4.4482216152605), "MZ": ("ft-lb", 1.3558179483),
      "P": ("psi", 6894.757293168), "V": ("mph", 0.44704)}  # fmt: skip


@pytest.mark.parametrize(
    "units",
    [
        US,
        US | {"MZ": ("in-lb", 0.112984829), "V": ("ft/s", 0.3048)},
        US | {"P": ("bar(g)", 1e5), "FZ": ("kgf", 9.80665)},
    ],
)
def test_units_of_other_countries(units, tmp_path):
    columns = tire.sweep(tire.wave())
    n = len(columns["ET"])
    columns |= {"P": np.full(n, 83e3), "V": np.full(n, 11.1)}
    written = {k: v / units[k][1] if k in units else v for k, v in columns.items()}
    text = tire.text_of(written, {k: u for k, (u, _) in units.items()}, "\t")
    path, tir = tire.files(tmp_path, "Round 9; Tire: made up\n" + text, "run.dat")
    found = study(path)
    agrees(found)
    exact(found, tir)
    assert found.columns["mz"] == pytest.approx(columns["MZ"], abs=1e-4)
    assert found.columns["pressure"] == pytest.approx(columns["P"], rel=1e-5)
    assert found.columns["speed"] == pytest.approx(columns["V"], rel=1e-5)


def test_an_unknown_unit_stops_a_file_only_where_it_is_needed(tmp_path):
    columns = tire.sweep(tire.wave())
    found = study(tire.files(tmp_path, tire.text_of(columns, {"MZ": "furlong"}))[0])
    agrees(found)
    assert "column 'MZ' was left out: unknown unit 'furlong'" in found.said
    with pytest.raises(FlatplankError, match="unknown unit 'furlong'"):
        study(tire.files(tmp_path, tire.text_of(columns, {"FZ": "furlong"}))[0])


@pytest.mark.parametrize(
    ("units", "words"),
    [
        ({"SA": "rad"}, "'SA' goes up to 687.5 deg"),
        ({"FZ": "kN", "FY": "N", "SA": "deg"}, None),
        ({"FY": "kN"}, r"'FY' goes up to .* N at a load of 1200 N"),
    ],
)
def test_values_that_contradict_their_unit_are_refused(units, words, tmp_path):
    columns = tire.sweep(tire.wave())
    if words is None:  # stated and true
        columns["FZ"] = columns["FZ"] / 1000.0
        agrees(study(tire.files(tmp_path, tire.text_of(columns, units))[0]))
        return
    with pytest.raises(FlatplankError, match=words):
        study(tire.files(tmp_path, tire.text_of(columns, units))[0])


def comma(text: str) -> str:
    return text.replace(",", ";").replace(".", ",")


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_decimal_commas_and_encodings(encoding, tmp_path):
    text = comma(tire.text_of(tire.sweep(tire.wave()), {"SA": "°", "IA": "°"}))
    path, tir = tire.files(tmp_path, "Prüfstand Süd\n" + text, encoding=encoding)
    found = study(path)
    agrees(found)
    exact(found, tir)
    assert len(found.columns["fz"]) == 6 * N and len(found.said) == 1


def test_thousands_do_not_cost_the_large_forces(tmp_path):
    columns = tire.sweep(tire.wave())
    rows = ["SA;IA;FZ;FY", "deg;deg;N;N"]
    for values in zip(*(columns[k] for k in ("SA", "IA", "FZ", "FY")), strict=True):
        shown = [np.degrees(values[0]), np.degrees(values[1]), *values[2:]]
        rows.append(";".join(f"{v:,.3f}" for v in shown).translate(str.maketrans(",.", ".,")))
    found = study(tire.files(tmp_path, "\n".join(rows))[0])
    agrees(found)
    assert len(found.columns["fz"]) == 6 * N


LONG = {"ET": "Elapsed Time", "SA": "Slip Angle", "IA": "Inclination_Angle", "FZ": "Normal Load",
        "FY": "lateral-force", "MZ": "Aligning Torque"}  # fmt: skip


def test_long_names_and_names_of_ones_own(tmp_path, capsys):
    columns = tire.sweep(tire.wave())
    text = tire.text_of({LONG[k]: v for k, v in columns.items()})
    text = text.replace("-,-,-,-,-,-", "s,deg,deg,N,N,Nm", 1)
    lines = text.splitlines()
    text = "\n".join([lines[0], lines[1], *tire.text_of(columns).splitlines()[2:]])
    agrees(study(tire.files(tmp_path, text)[0]))
    own = text.replace("lateral-force", "Kistler 2", 1)
    path, _ = tire.files(tmp_path, own)
    with pytest.raises(FlatplankError, match="--columns"):
        study(path)
    agrees(study(path, names={"fy": "Kistler 2"}))
    assert main(["sweeps", str(path), "--columns", "FY=Kistler 2"]) == 0
    capsys.readouterr()
    for wrong, words in (("fy", "is not CHANNEL=COLUMN"), ("fq=Kistler 2", "no channel 'fq'"),
                         ("fy=Kistler", "no column 'Kistler'")):  # fmt: skip
        assert main(["sweeps", str(path), "--columns", wrong]) == 1
        assert words in capsys.readouterr().err


CHANNELS = {"ET": ("RUNTIME", "s"), "SA": ("SLIPANGL", "rad"), "FZ": ("FZW", "N"),
            "FY": ("FYW", "N"), "IA": ("INCLANGL", "rad"), "MZ": ("MZW", "Nm")}  # fmt: skip


def tydex(columns, names=CHANNELS, constants=None) -> str:
    channels = [Channel(*named) for named in names.values()]
    data = np.column_stack([columns[k] for k in names])
    return format_tydex(TydexFile({"RELEASE": "1.3"}, [], constants or {}, channels, data))


@pytest.mark.parametrize("held", [False, True])
def test_sweeps_in_tydex(held, tmp_path):
    columns = tire.sweep(tire.wave())
    names, constants = dict(CHANNELS), None
    if held:
        constants = {"INCLANGL": Quantity("deg", "4"), "INFLPRES": Quantity("kPa", "83")}
        del names["IA"]
        columns |= {"FY": tire.side_force(columns["FZ"], columns["SA"], np.radians(4.0))}
    path, tir = tire.files(tmp_path, tydex(columns, names, constants), "lateral.tdx")
    found = study(path)
    assert len(found.conditions) == 3 and len(found.columns["fz"]) == 6 * N
    if held:
        assert np.degrees(found.columns["gamma"]) == pytest.approx(4.0)
        assert found.columns["pressure"] == pytest.approx(83e3)
        assert all(f.error < 1.0 for f in found.failures(read_tir(str(tir))))
        return
    agrees(found)
    exact(found, tir)


def test_text_in_a_tydex_channel_that_no_curve_needs_costs_no_row(tmp_path):
    text = tydex(tire.sweep(tire.wave()))
    lines = text.splitlines()
    first = lines.index("**MEASURDATA") + 1
    for k in range(first + 100, first + 160):
        lines[k] = lines[k][:50] + "OVL".rjust(9)
    found = study(tire.files(tmp_path, "\n".join(lines), "lateral.tdx")[0])
    agrees(found)
    assert len(found.columns["fz"]) == 6 * N
    place = f"first 'OVL' in line {first + 101}"
    assert f"column 'MZW': 60 of {6 * N} cells are not numbers, {place}" in found.said


SHAPES = {
    "vectors and units": lambda columns, units: {**columns, "units": units},
    "vectors and channel": lambda columns, units: {
        **columns, "channel": {"name": list(units), "units": list(units.values())}},
    "a struct": lambda columns, units: {"run": columns, "units": units},
}  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES)
def test_sweeps_in_matlab_73(shape, tmp_path):
    columns = tire.sweep(tire.wave())
    shown = {k: tire.FACTORS.get(k, 1.0) * v for k, v in columns.items()}
    units = {k: tire.UNITS[k] for k in columns}
    path, tir = tire.files(tmp_path, "", "lateral.mat")
    write_mat73(path, SHAPES[shape](shown, units))
    found = study(path)
    agrees(found)
    exact(found, tir)
    for name, (theirs, factor) in {"fy": ("FY", 1.0), "alpha": ("SA", np.pi / 180.0)}.items():
        with h5py.File(path) as file:  # an independent reader
            values = file.get("run", file)[theirs][()].ravel()
        np.testing.assert_allclose(found.columns[name], factor * values, rtol=1e-12)
    assert len(found.said) == 1
