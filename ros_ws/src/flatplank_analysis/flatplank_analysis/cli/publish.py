# SPDX-License-Identifier: Apache-2.0
"""Metadata of a campaign for a repository of research data.

RO-Crate with what a DOI needs; nothing is sent.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from datetime import date
from pathlib import Path

from flatplank_analysis.cli import common
from flatplank_data.crate import FILE, Publication, crate_of
from flatplank_data.files import write_atomic


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank publish DIR --publisher NAME --license SPDX [--author 'NAME ORCID'...]`."""
    parser = common.campaign_parser("publish", __doc__)
    parser.add_argument("--publisher", metavar="NAME", required=True, help="repository or house")
    parser.add_argument(
        "--license", metavar="SPDX", required=True, help="identifier, as CC-BY-4.0 or CC0-1.0"
    )
    parser.add_argument(
        "--author", metavar="'NAME ORCID'", nargs="+", default=[],
        help="default: the operators of the run records",
    )  # fmt: skip
    parser.add_argument("--title", default="", help="default: from the tires")
    parser.add_argument("--description", default="", help="default: from the run records")
    parser.add_argument("--doi", default="", help="as 10.4121/abc, when it is known")
    parser.add_argument("--date", default="", help="of publication, ISO 8601; default: today")
    arguments = parser.parse_args(argv)
    return common.run_or_report_nothing_usable("publish", lambda: _run(arguments))


def _run(o: argparse.Namespace) -> int:
    campaign = common.load_folder(o.folder, o.mapping)
    operators = dict.fromkeys(i.operator for i in campaign.infos if i.operator)
    day = o.date or date.today().isoformat()
    publication = Publication(
        o.author or list(operators), o.publisher, o.license, day, o.title, o.description, o.doi
    )
    crate = crate_of(campaign, publication)
    path = Path(o.folder) / FILE
    write_atomic(path, json.dumps(crate, indent=1, ensure_ascii=False) + "\n")
    common.print_problems(campaign.problems)
    files = sum(entity["@type"] == "File" for entity in crate["@graph"])
    if o.json:
        problems = [str(p) for p in campaign.problems]
        common.print_json({"file": str(path), "files": files, "problems": problems})
    else:
        print(f"{path}: {len(campaign)} runs, {files} files")
        print("without --doi: add it when it is registered" if not o.doi else f"DOI {o.doi}")
    return 0
