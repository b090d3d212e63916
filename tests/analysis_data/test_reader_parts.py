# SPDX-License-Identifier: Apache-2.0
"""Names, units and signs of foreign columns; text tables, MATLAB variables and Parquet columns."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from flatplank_data.errors import FlatplankError
from flatplank_data.readers import base
from flatplank_data.readers.base import Loaded, Request
from flatplank_data.readers.csv import read_csv
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


ONE, TWO = np.array([1.0, 2.0]), np.array([3.0, 4.0])


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


def test_the_run_record_in_a_parquet_file(tmp_path):
    loaded = parquet(tmp_path, {"fx": ONE}, meta={INFO_KEY: b'{"kappa": 0.1}'})
    assert loaded.facts == {"kappa": 0.1} == describe_parquet(LocalStore(str(tmp_path)), "run")
    assert parquet(tmp_path, {"fx": ONE}).facts == {}
    assert describe_parquet(LocalStore(str(tmp_path)), "run") == {}
    with pytest.raises(FlatplankError, match="its run record is no mapping"):
        parquet(tmp_path, {"fx": ONE}, meta={INFO_KEY: b"[1]"})
