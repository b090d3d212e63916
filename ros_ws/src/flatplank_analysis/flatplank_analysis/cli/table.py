# SPDX-License-Identifier: Apache-2.0
"""What a campaign holds: conditions, repeats, what is missing.

What is missing is said for each parameter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from flatplank_analysis.cli import common
from flatplank_analysis.identify.results import to_plain
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.exporters import EXPORTERS, export_campaign
from flatplank_data.lost import lost_samples
from flatplank_data.needs import parameters_and_missing_runs
from flatplank_data.run_record import RunRecord


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank table DIR [--json] [--export DIR --as SUFFIX]`."""
    parser = common.campaign_parser("table", __doc__)
    parser.add_argument("--export", metavar="DIR", help="write the runs there as tables")
    parser.add_argument("--as", dest="suffix", default=".parquet", choices=sorted(EXPORTERS))
    arguments = parser.parse_args(argv)
    return common.run_or_report_nothing_usable("table", lambda: _run(arguments))


def _run(arguments) -> int:
    campaign = common.load_folder(arguments.folder, arguments.mapping)
    # read every run once, so that all problems are known
    sizes = [(table.info, len(table)) for table in campaign.tables()]
    infos, samples = [info for info, _ in sizes], sum(size for _, size in sizes)
    lost = _lost(campaign, {info.file for info in infos})
    common.print_problems(campaign.problems)
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


def _lost(campaign: Campaign, used: set[str]) -> list[dict[str, Any]]:
    """Runs that lack samples, including those that are not used for this reason."""
    found = []
    for run in campaign.runs:
        try:
            lost = lost_samples(run.table(("time", "plank_position"), check=False))
        except FlatplankError:
            continue  # listed among the problems
        if lost.lost:
            numbers = {k: getattr(lost, k) for k in ("lost", "of", "longest", "road")}
            found.append({"file": run.info.file, "used": run.info.file in used} | numbers)
    return found


def summary(
    campaign: Campaign,
    infos: Sequence[RunRecord],
    samples: int,
    lost: Sequence[Mapping[str, Any]] = (),
) -> dict[str, Any]:
    """Content of the folder as plain values."""
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
        "parameters": parameters_and_missing_runs(infos),
        "lost": list(lost),
        "problems": [str(p) for p in campaign.problems],
    }


def _print(found: dict[str, Any]) -> None:
    print(f"{found['campaign']}: {found['runs']} runs, tire {found['tire'] or 'not named'}\n")
    header = (
        "measurement", "Fz [N]", "p [bar]", "alpha [deg]", "gamma [deg]", "kappa [%]", "runs",
        "starts", "lost",
    )  # fmt: skip
    rows = []
    for c in found["conditions"]:
        numbers = [c[k] for k in ("fz", "pressure", "alpha_deg", "gamma_deg")]
        numbers.append(None if c["kappa"] is None else 100.0 * c["kappa"])
        starts = " ".join(map(str, c["starts"]))
        counts = (str(c["runs"]), starts, str(c["cycles_lost"]))
        rows.append((c["measurement"], *map(_text, numbers), *counts))
    common.print_rows(header, rows)
    if found["lost"]:
        print("\nlost: cycles without a sample")
        columns = ("run", "lost", "of", "longest [s]", "road [mm]", "used")
        lost = [
            (e["file"], str(e["lost"]), str(e["of"]), _text(e["longest"]), _text(1e3 * e["road"]),
             "yes" if e["used"] else "no")
            for e in found["lost"]
        ]  # fmt: skip
        common.print_rows(columns, lost)
    print("\nparameters that these runs can tell:")
    for item in found["parameters"]:
        if not item["missing"]:
            print(f"  {item['parameters']}: {item['meaning']}")
    print("\nmissing:")
    for item in found["parameters"]:
        if item["missing"]:
            print(f"  {item['parameters']} ({item['meaning']}): {item['missing']}")


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:.6g}"
