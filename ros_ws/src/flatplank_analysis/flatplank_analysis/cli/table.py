# SPDX-License-Identifier: Apache-2.0
"""What a campaign folder holds: conditions, repeats, and what is missing for which parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from flatplank_analysis.cli import common
from flatplank_analysis.identify.results import to_plain
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.exporters import EXPORTERS, export_campaign
from flatplank_data.lost import lost_samples
from flatplank_data.needs import what_is_missing
from flatplank_data.run_record import RunRecord


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank table DIR [--json] [--export DIR --as SUFFIX]`."""
    parser = common.campaign_parser("table", __doc__)
    parser.add_argument("--export", metavar="DIR", help="write the runs there as tables")
    parser.add_argument("--as", dest="suffix", default=".parquet", choices=sorted(EXPORTERS))
    arguments = parser.parse_args(argv)
    return common.guarded("table", lambda: _run(arguments))


def _run(arguments) -> int:
    campaign = common.load_campaign(arguments)
    infos, samples = _usable(campaign)
    lost = _lost(campaign, {info.file for info in infos})
    common.tell(campaign.problems)
    if not infos:
        raise NothingUsableError("no run could be used", campaign.path, "see the problems above")
    if arguments.export:
        export_campaign(campaign.tables(), arguments.export, arguments.suffix)
    found = summary(campaign, infos, samples, lost)
    if arguments.json:
        common.print_json(found)
    else:
        _print(found)
    return 0


def _usable(campaign: Campaign) -> tuple[list[RunRecord], int]:
    """Read every run once, one at a time, so that all its problems are known."""
    infos, samples = [], 0
    for table in campaign.tables():
        infos.append(table.info)
        samples += len(table)
    return infos, samples


def _lost(campaign: Campaign, used: set[str]) -> list[dict[str, Any]]:
    """Runs that lack samples, also those that are not used because of it."""
    found = []
    for run in campaign.runs:
        try:
            lost = lost_samples(run.table(("time", "plank_position"), check=False))
        except FlatplankError:
            continue  # among the problems
        if lost.lost:
            numbers = {"lost": lost.lost, "of": lost.of, "longest": lost.longest}
            named = {"file": run.info.file, "used": run.info.file in used}
            found.append(named | numbers | {"road": lost.road})
    return found


def summary(
    campaign: Campaign,
    infos: Sequence[RunRecord],
    samples: int,
    lost: Sequence[Mapping[str, Any]] = (),
) -> dict[str, Any]:
    """The content of the folder as plain values."""
    conditions_of = {run.info.file: run.info.condition for run in campaign.runs}
    groups: dict[Any, list[RunRecord]] = {}
    for info in infos:
        groups.setdefault(info.condition, []).append(info)
    conditions = [
        {
            **to_plain(condition._asdict()),
            "runs": len(members),
            "starts": sorted({m.start for m in members}),
            "files": [m.file for m in members],
            "cycles_lost": sum(e["lost"] for e in lost if conditions_of[e["file"]] == condition),
        }
        for condition, members in sorted(groups.items(), key=lambda item: item[0].sort_key)
    ]
    return {
        "format": "flatplank-table/1",
        "campaign": campaign.path,
        "tire": campaign.tire or infos[0].tire,
        "runs": len(infos),
        "samples": samples,
        "conditions": conditions,
        "parameters": what_is_missing(infos),
        "lost": list(lost),
        "problems": [str(p) for p in campaign.problems],
    }


def _print(found: dict[str, Any]) -> None:
    print(f"{found['campaign']}: {found['runs']} runs, tire {found['tire'] or 'not named'}\n")
    header = ("measurement", "Fz [N]", "p [bar]", "alpha", "gamma", "kappa [%]", "runs", "starts",
              "lost")  # fmt: skip
    rows = [
        (
            c["measurement"],
            _text(c["fz"]),
            _text(c["pressure"]),
            _text(c["alpha_deg"]),
            _text(c["gamma_deg"]),
            _text(None if c["kappa"] is None else 100.0 * c["kappa"]),
            str(c["runs"]),
            " ".join(str(s) for s in c["starts"]),
            str(c["cycles_lost"]),
        )
        for c in found["conditions"]
    ]
    common.print_rows(header, rows)
    if found["lost"]:
        print("\nlost: cycles without a sample")
        columns = ("run", "lost", "of", "longest [s]", "road [mm]", "used")
        common.print_rows(columns, [_lost_row(entry) for entry in found["lost"]])
    print("\nparameters that these runs can tell:")
    for item in found["parameters"]:
        if not item["missing"]:
            print(f"  {item['parameters']}: {item['meaning']}")
    print("\nmissing:")
    for item in found["parameters"]:
        if item["missing"]:
            print(f"  {item['parameters']} ({item['meaning']}): {item['missing']}")


def _lost_row(entry: Mapping[str, Any]) -> tuple[str, ...]:
    numbers = (str(entry["lost"]), str(entry["of"]), _text(entry["longest"]))
    return (entry["file"], *numbers, _text(1e3 * entry["road"]), "yes" if entry["used"] else "no")


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:.6g}"
