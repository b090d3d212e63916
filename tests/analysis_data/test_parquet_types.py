# SPDX-License-Identifier: Apache-2.0
"""Parquet files as other programs write them, compared with pandas; damage; bombs."""

from __future__ import annotations

from decimal import Decimal

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from flatplank_data.errors import FlatplankError
from flatplank_data.readers.base import Request
from flatplank_data.readers.parquet import read_parquet
from flatplank_data.store import LocalStore

ROWS = 300
SECONDS = 0.2 * np.arange(ROWS)
NANOS = (SECONDS * 1e9).round().astype(np.int64)
START = 1_700_000_000_000_000_000


def read(folder, table, mapping=None):
    pq.write_table(table, folder / "r.parquet")
    return read_parquet(Request(LocalStore(str(folder)), "r.parquet", None, mapping)).columns


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
@pytest.mark.parametrize(
    "kind",
    [
        lambda unit: pa.duration(unit),
        lambda unit: pa.timestamp(unit),
        lambda unit: pa.timestamp(unit, tz="Europe/Amsterdam"),
    ],
)
def test_times_are_in_seconds_as_pandas_has_them(tmp_path, unit, kind):
    """Across a change to daylight saving, too."""
    per = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}[unit]
    kind = kind(unit)
    first = 0 if pa.types.is_duration(kind) else 1_711_846_700 * per  # 2024-03-31, 01:58 there
    ticks = first + (np.arange(ROWS) * (per if unit == "s" else per // 5))
    found = read(tmp_path, pa.table({"time": pa.array(ticks, kind), "fx": SECONDS}))["time"]
    series = pd.read_parquet(tmp_path / "r.parquet")["time"]
    expected = (series - series.iloc[0]).dt.total_seconds()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    assert found[-1] > 10.0


@pytest.mark.parametrize(("unit", "per"), [("us", 1000), ("ns", 1)])
def test_nanoseconds_since_1970_as_integers_keep_their_steps(tmp_path, unit, per):
    field = pa.field("time", pa.int64(), metadata={"unit": unit})
    columns = [pa.array(START // per + NANOS // per), pa.array(SECONDS)]
    found = read(tmp_path, pa.table(columns, schema=pa.schema([field, ("fx", pa.float64())])))
    np.testing.assert_allclose(np.diff(found["time"]), 0.2, rtol=0.0, atol=1e-9 * per)


@pytest.mark.parametrize(
    "kind",
    [pa.int8(), pa.uint16(), pa.int32(), pa.int64(), pa.uint64(), pa.float16(), pa.float32(),
     pa.dictionary(pa.int32(), pa.float64()), pa.dictionary(pa.int8(), pa.float32()),
     pa.decimal128(9, 2), pa.decimal256(20, 3)],
    ids=str,
)  # fmt: skip
def test_numbers_of_every_type_are_those_of_pandas(tmp_path, kind):
    values = np.arange(ROWS) % 100
    if pa.types.is_decimal(kind):
        column = pa.array([Decimal(int(v)) for v in values], kind)
    elif pa.types.is_dictionary(kind):
        column = pa.array(values.astype(float)).cast(kind.value_type).dictionary_encode()
        column = column.cast(kind)
    else:
        column = pa.array(values.astype(kind.to_pandas_dtype()))
    found = read(tmp_path, pa.table({"time": SECONDS, "fx": column}))
    expected = pd.read_parquet(tmp_path / "r.parquet")["fx"].astype(float)
    np.testing.assert_array_equal(found["fx"], expected)
    np.testing.assert_array_equal(found["fx"], values)


def test_missing_values_are_nan_as_in_pandas(tmp_path):
    values = [None if i % 7 == 3 else i for i in range(ROWS)]
    table = pa.table({"time": SECONDS, "fx": pa.array(values, pa.int32()), "fy": pa.nulls(ROWS)})
    found = read(tmp_path, table)
    np.testing.assert_array_equal(found["fx"], [np.nan if v is None else v for v in values])
    assert np.isnan(found["fy"]).all()


@pytest.mark.parametrize(
    ("column", "kind"),
    [
        (pa.array(["0.5"] * ROWS), "string"),
        (pa.array(["0.5"] * ROWS).dictionary_encode(), "string"),
        (pa.array([[0.5]] * ROWS), "list"),
        (pa.array([{"a": 0.5}] * ROWS), "struct"),
        (pa.array(NANOS, pa.duration("ns")), "duration"),
        (pa.array(NANOS, pa.timestamp("ns")), "timestamp"),
        (pa.array(np.arange(ROWS, dtype=np.int32), pa.date32()), "date32"),
        (pa.array([b"x"] * ROWS), "binary"),
    ],
    ids=lambda v: v if isinstance(v, str) else "",
)
def test_what_is_no_number_is_refused_with_its_type(tmp_path, column, kind):
    with pytest.raises(FlatplankError, match=f"r.parquet, 'fx': its type is .*{kind}"):
        read(tmp_path, pa.table({"time": SECONDS, "fx": column}))


def test_contradictions_and_doubles_are_refused(tmp_path):
    field = pa.field("time", pa.duration("ns"), metadata={"unit": "m"})
    with pytest.raises(FlatplankError, match=r"its unit is 'm', its type duration\[ns\]"):
        read(tmp_path, pa.table([pa.array(NANOS, field.type)], schema=pa.schema([field])))
    with pytest.raises(FlatplankError, match="two columns 'fx'"):
        read(tmp_path, pa.table([SECONDS, SECONDS, SECONDS], names=["time", "fx", "fx"]))


def test_a_file_that_fills_the_memory_is_refused(tmp_path):
    """50 million equal rows take 1 kB."""
    table = pa.table({"time": pa.array(np.zeros(50_000_000))})
    with pytest.raises(FlatplankError, match="unpacks to more than 1000 times its size"):
        read(tmp_path, table)
