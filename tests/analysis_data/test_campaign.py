# SPDX-License-Identifier: Apache-2.0
"""A campaign is read lazily; what is wrong with one file is told, the others go on."""

from __future__ import annotations

import dataclasses
import json
import pickle

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from flatplank_analysis.pages.provenance import provenance
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.naming import facts_of_name, name_of, numbered
from flatplank_data.readers.parquet import INFO_KEY
from flatplank_data.run_record import RunRecord, read_run
from flatplank_data.table import MeasurementTable


def _problems(folder):
    campaign = Campaign.load(folder)
    good = list(campaign.tables())
    return good, campaign.problems


def test_conditions_and_repeats(write_campaign, make_step):
    tables = [make_step(k, s) for k in (0.01, -0.01) for s in (1, 2, 3)]
    campaign = Campaign.load(write_campaign(tables))
    conditions = campaign.conditions()
    assert [c.kappa for c in conditions] == [-0.01, 0.01]
    assert all(len(runs) == 3 for runs in conditions.values())
    assert len(campaign.where(lambda info: info.start == 2)) == 2


def test_only_the_wanted_columns_are_read(write_campaign, make_step):
    campaign = Campaign.load(write_campaign([make_step()]))
    table = campaign.runs[0].table(["fx", "plank_position"])
    assert set(table.columns) == {"fx", "plank_position"}
    with pytest.raises(ValueError, match="read-only"):
        table["fx"][0] = 1.0


def test_without_campaign_yaml_names_and_metadata_tell(write_campaign, make_step):
    folder = write_campaign([make_step(0.05, 2)])
    (folder / "campaign.yaml").unlink()
    info = Campaign.load(folder).infos[0]
    assert (info.kappa, info.start, info.fz, info.pressure) == (0.05, 2, 3700.0, 2.5)
    assert info.step_position == 1.5


def test_records_have_what_only_the_files_of_the_runs_state(write_campaign, make_step):
    table = make_step(0.05, 2)
    own = {"started": "2026-05-01T10:00:00+00:00", "plant": {"seed": 7}, "fz": 1.0}
    folder = write_campaign([table])
    path = folder / table.info.file
    whole = pq.read_table(path)
    metadata = {INFO_KEY: json.dumps(table.info.to_dict() | own)}
    pq.write_table(whole.replace_schema_metadata(metadata), path)
    (record,) = Campaign.load(folder).records()
    assert (record.day, record.bench, record.plant["seed"]) == ("2026-05-01", "simulated", 7)
    assert record.fz == table.info.fz
    assert "on the simulated bench (seed 7) measured 2026-05-01" in provenance([record])


def test_merged_campaigns_keep_all_runs(write_campaign, make_step):
    one = Campaign.load(write_campaign([make_step(0.01)], name="a"))
    two = Campaign.load(write_campaign([make_step(0.02)], name="b"))
    both = one.merged(two)
    assert len(list(both.tables())) == 2


def _nan(table):
    fx = table["fx"].copy()
    fx[100:110] = np.nan
    return table.with_columns(fx=fx)


def _goes_back(table):
    x = table["plank_position"].copy()
    x[500:] -= 0.3
    return table.with_columns(plank_position=x)


BAD = {
    "NaN": (_nan, {}, "row 101, column 'fx'"),
    "backward": (_goes_back, {}, "goes back"),
    "short": (lambda t: t.rows(slice(0, 700)), {}, "before the step"),
    "standstill": (lambda t: t.with_columns(plank_position=0 * t["fx"]), {}, "zero speed"),
    "hanging": (lambda t: t.with_columns(fz=-t["fz"]), {}, "fz > 0"),
    "wheel backward": (
        lambda t: t.with_columns(wheel_velocity=-t["wheel_velocity"]),
        {},
        "against each other",
    ),
    "sign of kappa": (lambda t: t, {"kappa": -0.05}, "driving is positive"),
    "kappa in percent": (lambda t: t, {"kappa": 5.0}, "0.05 means 5 %"),
    "time": (lambda t: t.with_columns(time=t["time"][::-1]), {}, "time does not increase"),
}


@pytest.mark.parametrize("case", BAD)
def test_one_bad_run_is_told_and_the_others_go_on(case, write_campaign, make_step, edit_campaign):
    change, entry, words = BAD[case]
    folder = write_campaign([make_step(0.02, 1), change(make_step(0.05, 2))])
    edit_campaign(folder, 1, **entry)
    good, problems = _problems(folder)
    assert [t.info.start for t in good] == [1]
    (problem,) = problems
    assert words in str(problem) and problem.remedy and "\n" not in str(problem)
    assert "5perc" in problem.file


def test_a_nominal_load_of_zero_is_a_remark(write_campaign, make_step, edit_campaign):
    folder = write_campaign([make_step(0.02, k, noise=1.0) for k in (1, 2)])
    edit_campaign(folder, 1, fz=0.0)
    good, problems = _problems(folder)
    assert len(good) == 2
    assert "nominal 0 N" in str(problems[0]) and not problems[0].fatal


def test_two_runs_with_one_uuid(write_campaign, make_step, edit_campaign):
    folder = write_campaign([make_step(0.02, 1), make_step(0.02, 2)])
    for index in (0, 1):
        edit_campaign(folder, index, uuid="7f3a")
    good, problems = _problems(folder)
    assert len(good) == 1 and "7f3a" in str(problems[0])


def test_uuid_of_the_file_itself_counts(write_campaign, make_step):
    folder = write_campaign([make_step(0.02, 1, uuid="7f3a"), make_step(0.02, 2, uuid="7f3a")])
    (folder / "campaign.yaml").unlink()
    good, problems = _problems(folder)
    assert len(good) == 1 and "7f3a" in str(problems[0])


def test_truncated_parquet(write_campaign, make_step):
    folder = write_campaign([make_step(0.02, 1), make_step(0.05, 2)])
    path = next(folder.glob("*_5perc*"))
    path.write_bytes(path.read_bytes()[:-2000])
    good, problems = _problems(folder)
    assert len(good) == 1 and "not a whole Parquet file" in str(problems[0])


def test_truncated_csv_names_the_line(write_campaign, make_step):
    folder = write_campaign([make_step(0.02, 1), make_step(0.05, 2)], ".csv")
    path = next(folder.glob("*_5perc*"))
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:1000]) + "\n1.0,2.0")
    good, problems = _problems(folder)
    assert len(good) == 1 and "line 1001" in str(problems[0]) and "cut short" in str(problems[0])


def test_csv_with_one_missing_unit(write_campaign, make_step):
    folder = write_campaign([make_step(0.02, 1), make_step(0.05, 2)], ".csv")
    path = next(folder.glob("*_5perc*"))
    path.write_text(path.read_text().replace("fx [N]", "fx", 1))
    good, problems = _problems(folder)
    assert len(good) == 1 and "no unit" in str(problems[0])


def test_missing_column_and_unknown_one(write_campaign, make_step):
    folder = write_campaign([make_step(0.02, 1), make_step(0.05, 2)], ".csv")
    path = next(folder.glob("*_5perc*"))
    path.write_text(path.read_text().replace("fx [N]", "fxx [N]", 1))
    good, problems = _problems(folder)
    assert len(good) == 1 and "no column 'fx'" in str(problems[0])


def test_missing_file_and_misspelt_key(write_campaign, make_step, edit_campaign):
    folder = write_campaign([make_step(0.02, 1), make_step(0.05, 2)])
    edit_campaign(folder, 0, presure=2.5)
    edit_campaign(folder, 1, file="gone.parquet")
    good, problems = _problems(folder)
    assert len(good) == 1
    text = " ".join(str(p) for p in problems)
    assert "'presure' (nearest: 'pressure')" in text and "gone.parquet" in text


def test_nothing_usable_is_an_error(tmp_path):
    with pytest.raises(NothingUsableError, match="no usable run"):
        Campaign.load(tmp_path)
    with pytest.raises(FlatplankError, match="no such folder"):
        Campaign.load(tmp_path / "nowhere")


NAMES = [
    ("TOY_REL_LNG_5perc_T_p25_Fz5550_2", {"kappa": 0.05, "start": 2, "fz": 5550.0}),
    (
        "TOY_REL_COM_CAM_5deg_1deg_2perc_T_p25_Fz3700_3",
        {"gamma_deg": 5.0, "alpha_deg": 1.0, "kappa": 0.02},
    ),
    ("BMW_ERR_REL_LNG_T_p23_Fz1625_1", {"measurement": "free_rolling", "pressure": 2.3}),
    ("TOY_REL_LNG_-0.5perc_T_p25_Fz3700_1_r02", {"kappa": -0.005, "repeat": 2}),
    ("TOY_STF_T_p20_Fz6000_1", {"measurement": "stiffness"}),
]


@pytest.mark.parametrize(("name", "facts"), NAMES)
def test_names_of_appendix_f(name, facts):
    parsed = facts_of_name(name)
    assert {key: parsed[key] for key in facts} == pytest.approx(facts)
    assert numbered(name_of(vars(RunRecord(**parsed))), parsed["repeat"]) == name


TREE = {
    "ERR/TOY_ERR_REL_LNG_T_p25_Fz3700_1": ("free_rolling", 0.0, 0.0, 0.0, 1),
    "REL_COM_CAM/TOY_REL_COM_CAM_5deg_1deg_2perc_T_p25_Fz3700_3": ("slip", 5.0, 1.0, 0.02, 3),
    "REL_LNG/TOY_REL_LNG_5perc_T_p25_Fz3700_2": ("slip", 0.0, 0.0, 0.05, 2),
    "REP_REL/TOY_REP_REL_5deg_1perc_T_p25_Fz3700_1": ("slip", 0.0, 5.0, 0.01, 1),
}
"""folder per type and name of Appendix F -> measurement, camber, side slip, slip, start"""


@pytest.mark.parametrize("protocol", ("", "file://"))
def test_the_folders_of_appendix_f_are_one_campaign(protocol, make_step, tmp_path):
    top = tmp_path / "TASS Aertssen"
    for name, (*_, kappa, start) in TREE.items():
        table = make_step(kappa, start)
        known = {INFO_KEY: b'{"step_position": 1.5, "effective_rolling_radius": 0.31}'}
        (top / name).parent.mkdir(parents=True)
        pq.write_table(pa.table(dict(table.columns), metadata=known), top / f"{name}.parquet")
    (top / "figures").mkdir()
    (top / "figures" / "TOY_REL_LNG_1perc_T_p25_Fz3700_1.parquet").write_bytes(b"no run")
    campaign = Campaign.load(f"{protocol}{top}")
    found = {
        i.name: (i.measurement, i.gamma_deg, i.alpha_deg, i.kappa, i.start) for i in campaign.infos
    }
    assert found == {name.split("/")[1]: facts for name, facts in TREE.items()}
    assert len(list(campaign.tables())) == len(TREE), campaign.problems
    assert {i.file for i in campaign.infos} == {f"{name}.parquet" for name in TREE}


def test_run_record_round_trip():
    info = RunRecord(file="a.parquet", tire="TOY", kappa=-0.02, fz=3700.0, uuid="u", notes="n")
    again, remarks = read_run(info.to_dict(), "test")
    assert again == info and not remarks


def test_operating_points_of_other_processes_meet(make_step):
    point = make_step(0.02).info.condition.operating_point
    there = pickle.loads(pickle.dumps(point))
    assert there == point and len({there, point}) == 1


ZEROS = {
    "kappa": (0.05, 0.0),
    "alpha_deg": (2.0, 0.0),
    "gamma_deg": (5.0, 0.0),
    "start": (2, 1),
    "start_angle_deg": (40.0, 0.0),
    "run_index": (7, 0),
    "repeat": (3, 1),
    "direction": (-1.0, 1.0),
    "wheel_camber_deg": (5.0, 0.0),
    "measurement": ("free_rolling", "slip"),
}
"""key -> what the file says, and what campaign.yaml says: zero, or the usual value"""


@pytest.mark.parametrize("key", ZEROS)
def test_what_campaign_yaml_says_counts_also_where_it_is_zero(
    key, write_campaign, make_step, edit_campaign
):
    own, said = ZEROS[key]
    table = make_step(0.05)
    table = MeasurementTable(table.columns, dataclasses.replace(table.info, **{key: own}))
    folder = write_campaign([table])
    edit_campaign(folder, 0, **{key: said})
    (run,) = Campaign.load(folder).runs
    assert getattr(run.table(check=False).info, key) == said
    edit_campaign(folder, 0, **{key: None})
    (run,) = Campaign.load(folder).runs
    assert getattr(run.table(check=False).info, key) == own
