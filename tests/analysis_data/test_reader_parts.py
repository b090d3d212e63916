# SPDX-License-Identifier: Apache-2.0
"""Names, units and signs of foreign columns; text tables, MATLAB variables and Parquet columns."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from flatplank_data import guard
from flatplank_data.errors import FlatplankError
from flatplank_data.readers import base, mat
from flatplank_data.readers.base import Loaded, Request
from flatplank_data.readers.csv import read_csv
from flatplank_data.readers.mat import read_mat
from flatplank_data.readers.parquet import INFO_KEY, describe_parquet, read_parquet
from flatplank_data.run_record import RunRecord
from flatplank_data.store import LocalStore
from flatplank_tire.numbers import NotNumbers


def asked(folder, name: str = "run", **options) -> Request:
    return Request(LocalStore(str(folder)), name, **options)


def assert_columns(loaded: Loaded, expected: dict) -> None:
    assert list(loaded.columns) == list(expected)
    for name, values in expected.items():
        np.testing.assert_allclose(loaded.columns[name], values, rtol=1e-12)


@pytest.mark.parametrize(
    ("options", "column", "wanted"),
    [
        ({}, "fx", True), ({}, "odd", True), ({"columns": ["fx"]}, "fx", True),
        ({"columns": ["fx"]}, "fz", False), ({"columns": ["fx"]}, "odd", False),
        ({"columns": []}, "fx", False), ({"columns": ["fx"], "further": True}, "odd", True),
        ({"columns": ["fx"], "further": True}, "fz", False),
    ],
)  # fmt: skip
def test_the_wanted_columns(options, column, wanted):
    assert asked(".", **options).wants(column) == wanted


@pytest.mark.parametrize(
    ("name", "suffix"),
    [("a.CSV", ".csv"), ("a.b.mat", ".mat"), ("a", ""), ("folder", ".mcap"), ("f.old", ".mcap"),
     ("f.mcap", ".mcap"), ("a.xls", ".xls")],
)  # fmt: skip
def test_a_reader_is_found_by_the_suffix_and_a_folder_is_a_bag(tmp_path, name, suffix):
    for folder in ("folder", "f.old"):
        (tmp_path / folder).mkdir()
    store = LocalStore(str(tmp_path))
    if suffix in base.suffixes():
        assert base.reader_for(store, name) is base._READERS[suffix]
        return
    with pytest.raises(FlatplankError) as raised:
        base.reader_for(store, name)
    assert raised.value.what == f"no reader for '{suffix or name}'"
    assert ".csv, .db3, .mat, .mcap" in raised.value.remedy and raised.value.where == name
    assert base.read_description(store, name) == {}


@pytest.mark.parametrize(
    ("names", "mapping", "further", "found", "remarks"),
    [
        (["fx", "Plank Position", "wheel-angle", "FZ"], None, False,
         {"fx": "fx", "Plank Position": "plank_position", "wheel-angle": "wheel_angle",
          "FZ": "fz"}, []),
        (["force"], {"columns": {"force": "fx"}}, False, {"force": "fx"}, []),
        (["fx"], {"columns": {"fx": "fy"}}, False, {"fx": "fy"}, []),
        (["qqq"], {"columns": None}, False, {},
         ["column 'qqq' is not known and was left out"]),
        (["qqq"], {"columns": {"qqq": 5}}, False, {},
         ["column 'qqq' is not known and was left out"]),
        (["wheel_angel"], None, False, {},
         ["column 'wheel_angel' is not known and was left out (nearest: 'wheel_angle')"]),
        (["WHEEL_ANGEL"], None, True, {"WHEEL_ANGEL": "WHEEL_ANGEL"},
         ["column 'WHEEL_ANGEL' is kept as a further coordinate (nearest: 'wheel_angle')"]),
        (["qqq", "fx"], None, True, {"qqq": "qqq", "fx": "fx"}, []),
        (["qqq"], {"columns": {"qqq": "zzz"}}, True, {"qqq": "zzz"}, []),
    ],
)  # fmt: skip
def test_our_names_of_foreign_columns(names, mapping, further, found, remarks):
    assert base.canonical_names(names, mapping, further) == (found, remarks)


def test_two_columns_that_are_the_same_one_are_refused():
    with pytest.raises(FlatplankError) as raised:
        base.canonical_names(["fx", "fz", "FX"], None)
    assert raised.value.what == "columns 'fx' and 'FX' are both 'fx'"


@pytest.mark.parametrize(
    ("name", "unit", "named", "factor"),
    [
        ("fx", "kN", "fx", 1e3), ("fx", None, "fx", 1.0), ("wheel_angle", "deg", "wheel_angle",
         np.pi / 180.0), ("odd", "kN", "odd [kN]", 1.0), ("odd [kN]", "kN", "odd [kN]", 1.0),
        ("odd", None, "odd", 1.0), ("odd", "", "odd", 1.0),
    ],
)  # fmt: skip
def test_a_column_in_si_or_with_its_unit(name, unit, named, factor):
    found, values = base.column_of(np.array([1.0, 2.0]), unit, name, "a.csv")
    assert found == named
    np.testing.assert_allclose(values, [factor, 2.0 * factor])


def test_a_known_column_with_an_empty_unit_has_another_quantity():
    with pytest.raises(FlatplankError, match=r"a\.csv: unit '' does not fit"):
        base.column_of(np.array([1.0]), "", "fx", "a.csv")


def test_text_is_told_or_refused_where_the_run_needs_the_column():
    cells = NotNumbers(2, 9, "'in 5' in line 12")
    said = base.left_out(asked(".", needed=("fz",)), "Fx", "fx", cells)
    assert said == "column 'Fx': 2 of 9 cells are not numbers, first 'in 5' in line 12"
    with pytest.raises(FlatplankError) as raised:
        base.left_out(asked(".", needed=("fx",)), "Fx", "fx", cells)
    assert raised.value.what == "'in 5' in column 'Fx' is not a number"
    assert raised.value.where == "run, line 12"


@pytest.mark.parametrize(
    ("mapping", "names"),
    [(None, ()), ({}, ()), ({"turn": None}, ()), ({"turn": "fy"}, ("fy",)),
     ({"turn": ["kappa", "mz"]}, ("kappa", "mz"))],
)  # fmt: skip
def test_what_has_the_opposite_sign(mapping, names):
    assert base.turned_names(mapping) == names


@pytest.mark.parametrize("turn", ["fyy", ["fy", "pressures"], [["fy"]], [5]])
def test_an_unknown_name_cannot_be_turned(turn):
    with pytest.raises(FlatplankError) as raised:
        base.turned_names({"turn": turn})
    assert raised.value.where == "mapping, turn"
    assert raised.value.remedy.startswith("known: kappa, alpha_deg, gamma_deg, time,")


def test_columns_and_keys_are_turned_only_where_the_mapping_says_so():
    mapping = {"turn": ["fy", "alpha_deg", "gamma_deg", "kappa"]}
    columns = {"fx": np.array([1.0, -2.0]), "fy": np.array([3.0, -4.0])}
    turned = base.turned_columns(columns, mapping)
    np.testing.assert_array_equal(turned["fx"], [1.0, -2.0])
    np.testing.assert_array_equal(turned["fy"], [-3.0, 4.0])
    facts = {"alpha_deg": "2", "kappa": 0.0, "gamma_deg": None, "fy": 7.0, "fz": 1.0}
    assert base.turned_facts(facts, mapping) == {**facts, "alpha_deg": -2.0}
    assert str(base.turned_facts({"kappa": 0.0}, mapping)["kappa"]) == "0.0"
    record = RunRecord(alpha_deg=2.0, gamma_deg=-1.0, kappa=0.0, fz=5.0)
    info = base.turned_info(record, mapping)
    assert info == RunRecord(alpha_deg=-2.0, gamma_deg=1.0, kappa=0.0, fz=5.0)
    assert str(info.kappa) == "0.0"  # not -0
    assert base.turned_info(record, {"turn": "fy"}) == record


# text tables


def csv(folder, text: str, **options) -> Loaded:
    (folder / "run").write_text(text)
    return read_csv(asked(folder, **options))


def test_a_text_table_in_si(tmp_path):
    text = "time [ms];fx [kN];odd [bar];name\n0;1;4;x\n500;2;5;y\n"
    loaded = csv(tmp_path, text)
    assert_columns(loaded, {"time": [0.0, 0.5], "fx": [1e3, 2e3]})
    assert list(loaded.remarks) == [
        "column 'odd' is not known and was left out", "column 'name' is not known and was left out"
    ]  # fmt: skip
    further = csv(tmp_path, text, further=True, columns=["fx"])
    assert_columns(further, {"fx": [1e3, 2e3], "odd [bar]": [4.0, 5.0]})
    assert list(further.remarks) == ["column 'name' is text and was left out"]
    mapped = csv(tmp_path, text, mapping={"columns": {"odd": "pressure"}}, columns=["pressure"])
    assert_columns(mapped, {"pressure": [4e5, 5e5]})


def test_a_time_that_cannot_be_read_is_refused_only_where_it_is_needed(tmp_path):
    text = "time;fx\nyesterday;1\ntoday;2\n"
    loaded = csv(tmp_path, text)
    assert_columns(loaded, {"fx": [1.0, 2.0]})
    (remark,) = loaded.remarks
    assert remark.startswith("column 'time' was left out: 'yesterday' is neither a number")
    with pytest.raises(FlatplankError, match="'yesterday' is neither"):
        csv(tmp_path, text, needed=("time",))
    assert_columns(csv(tmp_path, text, columns=["fx"], needed=("time",)), {"fx": [1.0, 2.0]})


def test_text_among_numbers_of_a_known_column_is_not_a_number(tmp_path):
    loaded = csv(tmp_path, "fx;mz;odd\nOVL;x;1\n2;y;z\n", further=True)
    assert_columns(loaded, {"fx": [np.nan, 2.0], "mz": [np.nan] * 2, "odd": [1.0, np.nan]})
    assert list(loaded.remarks) == [
        "column 'fx': 1 of 2 cells are not numbers, first 'OVL' in line 2",
        "column 'mz': 2 of 2 cells are not numbers, first 'x' in line 2",
        "column 'odd': 1 of 2 cells are not numbers, first 'z' in line 3",
    ]


@pytest.mark.parametrize(
    ("head", "missing"),
    [
        ("fx [N];fz;motion_trigger", "fz"), ("fx;fz [N];motion_trigger", "fx"),
        ("fx [N];fz [N];motion_trigger", ""), ("fx;fz;motion_trigger", ""),
        ("fx;fz;motion_trigger [-]", ""),
    ],
)  # fmt: skip
def test_all_columns_have_a_unit_or_none_has(tmp_path, head, missing):
    if not missing:
        return assert_columns(
            csv(tmp_path, f"{head}\n1;2;1\n"), {"fx": [1.0], "fz": [2.0], "motion_trigger": [1.0]}
        )
    with pytest.raises(FlatplankError) as raised:
        csv(tmp_path, f"{head}\n1;2;1\n")
    assert raised.value.what == f"column '{missing}' has no unit while others have one"
    assert raised.value.where == "run, header"
    return None


# MATLAB variables


@pytest.fixture
def matlab(monkeypatch, tmp_path):
    """Reads variables as if a file had them."""
    (tmp_path / "run").write_bytes(b"")

    def read(values: dict, **options) -> Loaded:
        monkeypatch.setattr(mat, "variables", lambda data, where: dict(values))
        return read_mat(asked(tmp_path, **options))

    return read


ONE, TWO = np.array([1.0, 2.0]), np.array([3.0, 4.0])


@pytest.mark.parametrize(
    ("values", "columns", "facts"),
    [
        ({"fx": ONE, "fz": TWO}, {"fx": ONE, "fz": TWO}, {}),
        ({"fx": ONE, "kappa": 0.1, "tire": "TOY", "colour": "red", "start": 2},
         {"fx": ONE}, {"kappa": 0.1, "tire": "TOY", "start": 2}),
        ({"fx": ONE, "fy": np.ones((2, 2)), "kappa": TWO}, {"fx": ONE}, {}),
        ({"run": {"fx": ONE, "fz": 2.0}, "kappa": 0.1}, {"fx": ONE}, {"kappa": 0.1, "fz": 2.0}),
        ({"run": {"fx": ONE}, "units": {"fx": "kN"}}, {"fx": 1e3 * ONE}, {}),
        ({"run": {"fx": ONE, "units": {"fx": "kN"}}}, {"fx": 1e3 * ONE}, {}),
        ({"fx": ONE, "run": {"fz": TWO}}, {"fx": ONE}, {}),
        ({"a": {"fx": ONE}, "b": {"fx": TWO}}, {}, {}),
        ({"fx": ONE, "units": "SI"}, None, {}),
        ({"fx": ONE, "units": {"fx": ""}}, {"fx": ONE}, {}),
        ({"fx": ONE + 0j}, {"fx": ONE}, {}),
    ],
)  # fmt: skip
def test_variables_of_matlab(matlab, values, columns, facts):
    if columns is None:
        with pytest.raises(FlatplankError, match="'fx' has no unit while others have one"):
            matlab(values)
        return
    loaded = matlab(values)
    assert_columns(loaded, columns)
    assert loaded.facts == facts


def test_a_variable_without_a_unit_among_others_is_refused(matlab):
    with pytest.raises(FlatplankError) as raised:
        matlab({"fx": ONE, "fz": TWO, "units": {"fx": "kN"}})
    assert raised.value.remedy == "add units.fz"
    only = matlab({"fx": ONE, "fz": TWO, "units": {"fx": "kN"}}, columns=["fx"])
    assert_columns(only, {"fx": 1e3 * ONE})


def test_a_complex_variable_is_refused_with_its_first_row(matlab):
    with pytest.raises(FlatplankError) as raised:
        matlab({"fx": np.array([1.0, 2.0 + 3.0j, 1j])})
    assert raised.value.what == "'fx' is complex, first 2+3j"
    assert raised.value.where == "run, row 2"


def test_variables_that_are_not_known_are_told(matlab):
    assert list(matlab({"fx": ONE, "way": TWO}).remarks) == [
        "column 'way' is not known and was left out"
    ]


# Parquet columns


def parquet(folder, given: dict, units: dict | None = None, meta=None, **options) -> Loaded:
    arrays = {name: pa.array(values) for name, values in given.items()}
    fields = [
        pa.field(name, a.type, metadata={"unit": (units or {})[name]} if units else None)
        for name, a in arrays.items()
    ]
    table = pa.table(list(arrays.values()), schema=pa.schema(fields, metadata=meta))
    pq.write_table(table, folder / "run")
    return read_parquet(asked(folder, **options))


def test_units_names_and_types_of_parquet_columns(tmp_path):
    columns = {"Fx": ONE, "odd": [1, 2], "note": ["x", "y"], "motion_trigger": [True, False]}
    units = {"Fx": "kN", "odd": "bar", "note": "-", "motion_trigger": "-"}
    loaded = parquet(tmp_path, columns, units)
    assert_columns(loaded, {"fx": 1e3 * ONE, "motion_trigger": [1.0, 0.0]})
    further = parquet(tmp_path, columns, units, further=True, columns=["fx"])
    assert_columns(further, {"fx": 1e3 * ONE, "odd [bar]": ONE})
    plain = parquet(tmp_path, columns, mapping={"columns": {"odd": "fz"}}, columns=["fz"])
    assert_columns(plain, {"fz": ONE})


@pytest.mark.parametrize(
    ("values", "kind", "seconds"),
    [
        ([5, 1005, None], pa.timestamp("ms"), [0.0, 1.0, np.nan]),
        ([None, 7, 9], pa.timestamp("s"), [np.nan, 0.0, 2.0]),
        ([5, 1005, 2005], pa.duration("ms"), [0.005, 1.005, 2.005]),
        ([3, 5, 6], pa.int64(), [3.0, 5.0, 6.0]),
        ([2**53 - 1, 1, 2], pa.int64(), [2.0**53 - 1.0, 1.0, 2.0]),
        ([2**53, 2**53 + 1, 2**53 + 3], pa.int64(), [0.0, 1.0, 3.0]),
        ([-(2**53), 2 - 2**53, 0], pa.int64(), [0.0, 2.0, 2.0**53]),
        ([None, None, None], pa.int64(), [np.nan] * 3),
        ([None, None, None], pa.timestamp("s"), [np.nan] * 3),
    ],
)
def test_times_of_parquet(tmp_path, values, kind, seconds):
    """Large integers are seconds since the first, so that no digit is lost."""
    table = parquet(tmp_path, {"time": pa.array(values, kind)})
    np.testing.assert_array_equal(table.columns["time"], seconds)


def test_only_a_time_may_be_large_or_a_stamp(tmp_path):
    large = parquet(tmp_path, {"fx": pa.array([2**53, 2**53 + 2])})
    np.testing.assert_array_equal(large.columns["fx"], [2.0**53, 2.0**53 + 2.0])
    with pytest.raises(FlatplankError, match=r"no number of N") as raised:
        parquet(tmp_path, {"fx": pa.array([1, 2], pa.duration("s"))})
    assert raised.value.where == "run, 'fx'"


@pytest.mark.parametrize("stated", [None, "s", "ms"])
def test_a_duration_may_state_its_own_unit(tmp_path, stated):
    units = {"time": stated} if stated else None
    loaded = parquet(tmp_path, {"time": pa.array([0, 500], pa.duration("ms"))}, units)
    assert_columns(loaded, {"time": [0.0, 0.5]})


def test_the_run_record_in_a_parquet_file(tmp_path):
    loaded = parquet(tmp_path, {"fx": ONE}, meta={INFO_KEY: b'{"kappa": 0.1}'})
    assert loaded.facts == {"kappa": 0.1} == describe_parquet(LocalStore(str(tmp_path)), "run")
    assert parquet(tmp_path, {"fx": ONE}).facts == {}
    assert describe_parquet(LocalStore(str(tmp_path)), "run") == {}
    with pytest.raises(FlatplankError, match="its run record is no mapping"):
        parquet(tmp_path, {"fx": ONE}, meta={INFO_KEY: b"[1]"})


@pytest.mark.parametrize(("rows", "whole"), [(125, True), (126, False)])
def test_a_table_is_counted_with_eight_bytes_a_number(tmp_path, monkeypatch, rows, whole):
    """Three columns; the budget is 3,000 bytes."""
    monkeypatch.setattr(guard, "RATIO", 0)
    monkeypatch.setattr(guard, "ALWAYS", 3000)
    columns = {name: np.zeros(rows) for name in ("time", "fx", "odd")}
    if whole:
        assert parquet(tmp_path, columns).columns["fx"].size == rows
    else:
        with pytest.raises(FlatplankError, match="unpacks to more"):
            parquet(tmp_path, columns)
