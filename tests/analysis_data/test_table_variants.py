# SPDX-License-Identifier: Apache-2.0
"""One run as many programs and people write it: read as it is, or refused with the reason."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest
from steptable import step_table

from flatplank_data.campaign import Campaign

ENTRY = (
    "{file: r.csv, kappa: 0.05, fz: 3700.0, pressure: 2.5, start: 2, run_index: 0, "
    "effective_rolling_radius: 0.3108, step_position: 1.5}"
)
NAMES = ["time", "plank_position", "wheel_angle", "fx", "fz"]
UNITS = ["s", "m", "rad", "N", "N"]
HALF = 113


@pytest.fixture(scope="module")
def run() -> pd.DataFrame:
    table = step_table(0.05, noise=5.0)
    return pd.DataFrame({n: table[n] for n in NAMES}).iloc[::12].reset_index(drop=True)


def loaded(folder, data: str | bytes, entry: str = ENTRY):
    """The table, and all remarks as text; None for a refused run."""
    (folder / "campaign.yaml").write_text(
        f"format: flatplank-measurement-table/1\ntire: TOY\nruns:\n- {entry}\n"
    )
    (folder / "r.csv").write_bytes(data if isinstance(data, bytes) else data.encode())
    campaign = Campaign.load(folder)
    tables = list(campaign.tables())
    assert all("\n" not in str(p) for p in campaign.problems)
    return tables[0] if tables else None, "\n".join(map(str, campaign.problems))


def text(run: pd.DataFrame, sep: str = ";", decimal: str = ",", head: str = "", **more) -> str:
    whole = run.to_csv(index=False, sep=sep, decimal=decimal, float_format="%.12g", **more)
    return f"{head}\n{whole.split(chr(10), 1)[1]}" if head else whole


def thousands(run: pd.DataFrame) -> str:
    turned = str.maketrans(",.", ".,")
    rows = (";".join(f"{v:,.9f}".translate(turned) for v in row) for row in run.to_numpy())
    return "\n".join([";".join(NAMES), *rows])


def with_cell(name: str, row: int, cell: str) -> Callable[[pd.DataFrame], str]:
    def write(run: pd.DataFrame) -> str:
        cells = [*run.get(name, 0.0 * run["fx"])]
        cells[row] = cell
        return text(run.assign(**{name: cells}), ",", ".")

    return write


def in_unit(name: str, unit: str, factor: float, said: bool = True):
    def write(run: pd.DataFrame) -> str:
        units = [unit if n == name else u for n, u in zip(NAMES, UNITS, strict=True)]
        head = ";".join(f"{n} [{u}]" for n, u in zip(NAMES, units, strict=True))
        return text(run.assign(**{name: run[name] / factor}), head=head if said else "")

    return write


def stamped(form: str, start: str = "2024-05-01T23:59:50") -> Callable[[pd.DataFrame], str]:
    def write(run: pd.DataFrame) -> str:
        stamps = pd.Timestamp(start) + pd.to_timedelta(run["time"], unit="s")
        return text(run.assign(time=stamps.dt.strftime(form)), ";", ".")

    return write


def wrapped(low: float, turn: float, unit: str = "rad") -> Callable[[pd.DataFrame], str]:
    def write(run: pd.DataFrame) -> str:
        angle = np.mod(run["wheel_angle"] - low, turn) + low
        return in_unit("wheel_angle", unit, np.pi / 180.0 if unit == "deg" else 1.0)(
            run.assign(wheel_angle=angle)
        )

    return write


POUND, TURN = 4.4482216152605, 2.0 * np.pi
READ: dict[str, Callable[[pd.DataFrame], str | bytes]] = {
    "tabs, decimal comma": lambda run: text(run, "\t"),
    "bars, UTF-16": lambda run: text(run, "|").encode("utf-16"),
    "blanks, decimal comma": lambda run: text(run, " "),
    "commas in quotes": lambda run: text(run.map("{:.9f}".format).replace(r"\.", ",", regex=True),
                                         ",", quoting=1),
    "sep= of a spreadsheet": lambda run: "sep=;\n" + text(run),
    "a separator at each end": lambda run: "\n".join(f"{s};" for s in text(run).split("\n") if s),
    "units in a line": lambda run: text(run, head=";".join(NAMES) + "\n" + ";".join(UNITS)),
    "thousands by point": thousands,
    "other capitals": lambda run: text(run, head="Time;Plank Position;WHEEL-ANGLE;Fx;FZ"),
    "carriage returns": lambda run: text(run).replace("\n", "\r"),
    "text in another column": lambda run: text(run.assign(note="Run 1; good")),
    "dates in another column": lambda run: text(run.assign(stamp="2024-05-01 10:00"), ",", "."),
    "text in a first cell": with_cell("mz", 0, "--"),
    "text in a middle cell": with_cell("loaded_radius", HALF, "#REF!"),
    "text in a last cell": with_cell("mx", -1, "OVL"),
    "ISO 8601 across midnight": stamped("%Y-%m-%dT%H:%M:%S.%fZ"),
    "dates with a blank": stamped("%Y-%m-%d %H:%M:%S.%f"),
    "times of day across midnight": stamped("%H:%M:%S.%f"),
    "German dates across midnight": stamped("%d.%m.%Y %H:%M:%S,%f"),
    "German dates of a new year": stamped("%d.%m.%Y %H:%M:%S.%f", "2023-12-31T23:59:50"),
    "year first across midnight": stamped("%Y/%m/%d %H:%M:%S.%f"),
    "month first across midnight": stamped("%m/%d/%Y %I:%M:%S.%f %p", "2024-05-12T23:59:50"),
    "day first across midnight": stamped("%d/%m/%Y %H:%M:%S.%f", "2024-05-12T23:59:50"),
    "month or day first on one day": stamped("%m/%d/%Y %I:%M:%S.%f %p", "2024-05-01T11:59:50"),
    "a year of two digits on one day": stamped("%d.%m.%y %H:%M:%S.%f", "2024-05-01T11:59:50"),
    "a month by its name": stamped("%d-%b-%Y %H:%M:%S.%f"),
    "ms": in_unit("time", "ms", 1e-3),
    "kN": in_unit("fx", "kN", 1e3),
    "lbs": in_unit("fx", "lbs", POUND),
    "kp": in_unit("fz", "kp", 9.80665),
    "inches": in_unit("plank_position", "inches", 0.0254),
    "degrees by their sign": in_unit("wheel_angle", "°", np.pi / 180.0),
    "0 .. 2 pi": wrapped(0.0, TURN),
    "-pi .. pi": wrapped(-np.pi, TURN),
    "0 .. 360 deg": wrapped(0.0, TURN, "deg"),
    "rows reversed": lambda run: text(run[::-1]),
    "rows sorted by force": lambda run: text(run.sort_values("fx", kind="stable")),
    "two rows swapped": lambda run: text(run.iloc[[*range(99), 100, 99, *range(101, len(run))]]),
}  # fmt: skip
REFUSED = {
    "text in a needed cell": (with_cell("fx", HALF, "OVL"), "line 115: 'OVL' in column 'fx'"),
    "an empty needed cell": (with_cell("fx", -1, ""), "row 226, column 'fx'"),
    "minutes and seconds": (stamped("%M:%S.%f"), "line 2: '59:50.000000' is neither a number"),
    "month or day first": (stamped("%m/%d/%Y %H:%M:%S.%f"), "write the dates as 2024-05-31"),
    "a year of two digits": (stamped("%d.%m.%y %H:%M:%S.%f"), "its month or its year first"),
    "no date": (stamped("%d.%d.%Y %H:%M:%S.%f", "2024-05-13"), "line 2: '13.13.2024 00:00:00."),
    "stamps of seconds": (stamped("%H:%M:%S"), "stamps are repeated"),
    "ms unsaid": (in_unit("time", "", 1e-3, False), "'time' is in ms"),
    "days unsaid": (in_unit("time", "", 86400.0, False), "'time' is in d, not"),
    "a mean below the samples": (
        lambda run: text(run) + "Mean" + ";1" * (len(run.columns) - 1) + "\n",
        "'Mean' in line 228 is not a number as those above",
    ),
    "kN unsaid": (in_unit("fx", "", 1e3, False), "'fx' is in kn"),
    "kp unsaid": (in_unit("fz", "", 9.80665, False), "'fz' is in kgf"),
    "mm unsaid": (in_unit("plank_position", "", 1e-3, False), "'plank_position' is in mm"),
    "degrees unsaid": (in_unit("wheel_angle", "", np.pi / 180.0, False), "is in deg"),
    "an unknown unit": (in_unit("fz", "klbf", 1.0), "unknown unit 'klbf'"),
    "two names of one column": (lambda run: text(run.assign(FX=run["fx"])), "are both 'fx'"),
    "0 .. pi": (wrapped(0.0, np.pi), "which is no turn"),
    "-4 pi .. 4 pi": (wrapped(-4.0 * np.pi, 8.0 * np.pi), "which is no turn"),
    "rows at the end again": (lambda run: text(pd.concat([run, run[-3:]])), "row 227"),
    "stamps of ns as s": (in_unit("time", "", 1e-9, False), "'time' is in ns"),
}


@pytest.mark.parametrize("case", READ)
def test_every_way_of_writing_gives_the_same_run(case, run, tmp_path):
    table, told = loaded(tmp_path, READ[case](run))
    assert table is not None, told
    start = table["time"][0] - run["time"][0]
    np.testing.assert_allclose(table["time"] - start, run["time"], atol=1e-6)
    turned = table["wheel_angle"] - table["wheel_angle"][0]
    np.testing.assert_allclose(turned, run["wheel_angle"] - run["wheel_angle"][0], atol=1e-6)
    for name in ("plank_position", "fx", "fz"):
        np.testing.assert_allclose(table[name], run[name], rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_read_for_sure_is_refused_with_its_reason(case, run, tmp_path):
    write, words = REFUSED[case]
    table, told = loaded(tmp_path, write(run))
    assert table is None and words in told, told


def test_a_time_that_nobody_needs_costs_no_run(tmp_path):
    prints = pd.DataFrame({"time": ["59:50.1", "59:51.2"], "fz": [1850.0, 3700.0],
                           "half_length": [0.05, 0.071]})  # fmt: skip
    entry = "{file: r.csv, measurement: footprint, pressure: 2.5}"
    table, told = loaded(tmp_path, prints.to_csv(index=False, sep=";"), entry)
    np.testing.assert_array_equal(table["half_length"], prints["half_length"])
    assert "column 'time' was left out: '59:50.1' is neither a number" in told
