# SPDX-License-Identifier: Apache-2.0
"""What is read of a small file, row by row, and every remark word by word."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flatplank_analysis.slip_sweeps.channels import check_columns, check_values
from flatplank_analysis.slip_sweeps.file import read
from flatplank_data.errors import FlatplankError

N = 80
UNITS = {"ET": "s", "SA": "rad", "SL": "-", "FY": "N", "FZ": "N", "MZ": "Nm", "oil": "degC"}


def measured(**changed) -> dict[str, list]:
    """A slip angle that rises, under a load that the sensor counts downwards."""
    columns = {
        "SA": list(np.round(np.linspace(-0.1, 0.04, N), 6)), "FZ": [-3000.0] * N,
        "FY": list(np.round(np.linspace(-2500.0, 1000.0, N), 3)),
    } | changed  # fmt: skip
    return {k: v for k, v in columns.items() if v is not None}


def write(folder: Path, columns: dict[str, list], units: dict | None = UNITS, name="a.csv"):
    lines = [",".join(columns)]
    if units:
        lines.append(",".join(units.get(k, "-") for k in columns))
    lines += [",".join(f"{v}" for v in row) for row in zip(*columns.values(), strict=True)]
    (folder / name).write_text("\n".join(lines) + "\n")
    return folder / name


def without(values: list, rows) -> list:
    return ["" if k in set(rows) else v for k, v in enumerate(values)]


@pytest.mark.parametrize("kind", [str, Path])
@pytest.mark.parametrize("name", ["a.csv", "a.TXT"])
def test_a_file_with_units_is_read_as_it_is_and_nothing_is_said(kind, name, tmp_path):
    columns = measured(oil=list(range(N)))
    found = read(kind(write(tmp_path, columns, UNITS, name)))
    assert found.said == () and found.further == ("oil",)
    for theirs, ours in {"SA": "alpha", "FZ": "fz", "FY": "fy", "oil": "oil"}.items():
        assert found.columns[ours] == pytest.approx(columns[theirs]), theirs
    assert set(found.columns) == {"alpha", "fz", "fy", "oil"}


def test_assumed_units_are_said_with_the_largest_value_of_either_sign(tmp_path):
    assert read(write(tmp_path, measured(), None)).said == (
        "no unit in the file, taken to be: alpha in rad (up to 0.1), fy in N (up to 2.5e+03), "
        "fz in N (up to 3e+03)",
    )


@pytest.mark.parametrize("kind", [str, Path])
def test_a_file_that_is_not_there_or_of_another_kind_is_told_by_its_name(kind, tmp_path):
    path = tmp_path / "none.csv"
    with pytest.raises(FlatplankError) as caught:
        read(kind(path))
    assert (caught.value.what, caught.value.where) == ("No such file or directory", str(path))
    with pytest.raises(FlatplankError, match=r"not a file of sweeps; give one of \.mat, \.csv"):
        read(kind(tmp_path / "a.xyz"))


def test_a_column_of_another_name_is_that_which_was_named(tmp_path):
    columns = measured(Kistler=[7.0] * N)
    found = read(write(tmp_path, columns, UNITS | {"Kistler": "N"}), {"fx": "Kistler"})
    assert (found.columns["fx"] == 7.0).all() and found.further == ()


def test_rows_without_a_needed_number_are_left_out_and_counted(tmp_path):
    rows = np.arange(N)
    columns = measured(
        FZ=without(measured()["FZ"], [3, 40]), FY=without(measured()["FY"], [5, 6, 40]),
        MZ=without([1.0] * N, range(9)), ET=list(rows),
    )  # fmt: skip
    found = read(write(tmp_path, columns))
    kept = np.delete(rows, [3, 40])
    assert (found.columns["time"] == kept).all()
    fy, fz = (line.split("first")[0] for line in found.said)
    assert fy == "3 of 80 samples have no Fy: no number in 'FY', "
    assert fz == "2 of 80 samples are left out: no number in 'FZ', "
    assert np.isnan(found.columns["fy"]).nonzero()[0].tolist() == [4, 5]
    for line, place in zip(found.said, ("line 8", "line 6"), strict=True):
        assert place in line


def test_too_few_whole_rows_are_refused_with_what_is_missing(tmp_path):
    columns = {k: v[:49] for k, v in measured().items()}
    with pytest.raises(FlatplankError) as caught:
        read(write(tmp_path, columns))
    assert caught.value.what == "49 whole samples"
    assert caught.value.remedy == "a sweep needs 50 at least"
    with pytest.raises(FlatplankError, match=r"^.* 20 whole samples \(60 of 80 samples are left"):
        read(write(tmp_path, measured(FZ=without(measured()["FZ"], range(60)))))
    fifty = {k: v[:50] for k, v in measured().items()}
    assert len(read(write(tmp_path, fifty)).columns["fz"]) == 50


def test_a_channel_without_any_number_was_not_measured(tmp_path):
    found = read(write(tmp_path, measured(SL=[""] * N)))
    assert "kappa" not in found.columns
    assert "column 'SL' has no number and was not measured" in found.said


def test_a_channel_of_an_unknown_unit_is_left_out_unless_it_is_needed(tmp_path):
    path = write(tmp_path, measured(MZ=[1.0] * N), UNITS | {"MZ": "furlong"})
    found = read(path)
    assert found.said == ("column 'MZ' was left out: unknown unit 'furlong'",)
    with pytest.raises(FlatplankError) as caught:
        read(write(tmp_path, measured(), UNITS | {"FZ": "furlong"}))
    assert caught.value.where == f"{path}, 'FZ'"


def test_shuffled_rows_are_sorted_by_stamps_that_begin_at_zero(tmp_path):
    order = np.random.default_rng(1).permutation(N)
    columns = measured(ET=list(np.arange(N) / 100))
    columns["FZ"] = without(columns["FZ"], [20])
    found = read(write(tmp_path, {k: [v[i] for i in order] for k, v in columns.items()}))
    assert found.columns["time"] == pytest.approx(np.delete(np.arange(N), 20) / 100)
    assert found.columns["alpha"] == pytest.approx(np.delete(columns["SA"], 20))
    assert found.said[-1] == "rows are not in order of time: sorted by their stamps"


def test_stamps_that_tell_no_order_are_refused_at_the_first_step_back(tmp_path):
    """Sample 12 is left out; the first step back is that to sample 31."""
    stamps = list(range(N))
    stamps[30:] = [k % 7 for k in range(50)]
    columns = measured(ET=stamps, FZ=without(measured()["FZ"], [11]))
    with pytest.raises(FlatplankError) as caught:
        read(write(tmp_path, columns))
    assert caught.value.what == "time does not increase: 0 s after 29 s"
    assert caught.value.where.endswith("a.csv, sample 31")


def test_recordings_that_follow_one_another_keep_their_order(tmp_path):
    columns = {k: v * 3 for k, v in measured(ET=[k / 10 for k in range(N)]).items()}
    found = read(write(tmp_path, columns))
    assert found.columns["time"] == pytest.approx(columns["ET"])
    assert found.said == ("3 recordings follow one another: the time starts again",)
    gaps = columns | {"ET": without(columns["ET"], [7])}
    assert "recordings" not in " ".join(read(write(tmp_path, gaps)).said)


def test_text_is_left_out_and_said(tmp_path):
    columns = measured(note=["good"] * N, oil=["5.0"] * 70 + ["hot"] * 10, ET=["soon"] * N)
    found = read(write(tmp_path, columns))
    assert found.further == ("oil",) and "time" not in found.columns
    assert "column 'note' is text and was left out" in found.said
    (hot,) = (line for line in found.said if line.startswith("column 'oil': "))
    assert "10 of 80 cells are not numbers" in hot and "'hot'" in hot
    assert any("'ET'" in line for line in found.said) and len(found.said) == 3


@pytest.mark.parametrize(
    ("columns", "what", "remedy"),
    [
        (["alpha", "fy"], "no vertical force",
         "name it FZ, FORCE Z, FZW, or say --columns fz=THEIRS"),
        (["fz", "fy"], "neither slip angle nor slip",
         "name them SA, ALPHA, SLIP ANGLE, or SL, SR, KAPPA, or say --columns alpha=THEIRS"),
        (["fz", "alpha"], "neither Fx nor Fy", "name them fx and fy, or say --columns"),
        (["fz", "alpha", "fy"], "", ""), (["fz", "kappa", "fx"], "", ""),
    ],
)  # fmt: skip
def test_what_a_sweep_must_have(columns, what, remedy):
    if not what:
        check_columns(columns, "a.csv")
        return
    with pytest.raises(FlatplankError) as caught:
        check_columns(columns, "a.csv")
    assert (caught.value.what, caught.value.remedy) == (what, remedy)


def ramp(low: float, high: float) -> np.ndarray:
    return np.linspace(low, high, 50)


DEG = np.pi / 180.0
SUSPECT = "at a load of 3000 N"


@pytest.mark.parametrize(
    ("columns", "refused"),
    [
        ({"alpha": ramp(-95 * DEG, 0), "fy": ramp(0, 900)}, "'a' goes up to 95 deg"),
        ({"alpha": ramp(-85 * DEG, 0), "fy": ramp(0, 900)}, ""),
        ({"gamma": ramp(-95 * DEG, 0), "kappa": ramp(-1, 1), "fx": ramp(0, 900)}, "'g' goes up"),
        ({"alpha": ramp(-1.5 * DEG, 0.6 * DEG), "fy": ramp(-2.0, 1.0)}, SUSPECT),
        ({"alpha": ramp(-1.5 * DEG, 0.4 * DEG), "fy": ramp(-2.0, 1.0)}, ""),
        ({"alpha": ramp(3.0 * DEG, 3.5 * DEG), "fy": ramp(-2.0, 1.0)}, ""),
        ({"alpha": ramp(3.0 * DEG, 5.5 * DEG), "fy": ramp(-0.4, 0.1)}, SUSPECT),
        ({"alpha": ramp(-0.1, 0.1), "fy": ramp(-2000.0, 2.0)}, ""),
        ({"alpha": ramp(-0.1, 0.1), "fy": ramp(-1e5, 2.0)}, SUSPECT),
        ({"alpha": ramp(-0.1, 0.1), "fy": 0.0 * ramp(0, 1)}, ""),
        ({"alpha": ramp(-0.1, 0.1), "fy": ramp(-900, 900), "fx": ramp(-2, 2)}, ""),
        ({"kappa": ramp(0.0, 0.03), "fx": ramp(-2, 2)}, ""),
        ({"kappa": ramp(-0.05, 0.0), "fx": ramp(-2, 2)}, "'x' goes up to 2 N at a load of 3000 N"),
    ],
)  # fmt: skip
def test_values_that_contradict_their_unit_are_told(columns, refused):
    names = {"alpha": "a", "gamma": "g", "fx": "x", "fy": "y", "fz": "z"}
    columns = columns | {"fz": np.where(np.arange(50) == 9, np.nan, -3000.0)}
    if not refused:
        check_values(columns, names, "a.csv")
        return
    with pytest.raises(FlatplankError, match=refused):
        check_values(columns, names, "a.csv")
