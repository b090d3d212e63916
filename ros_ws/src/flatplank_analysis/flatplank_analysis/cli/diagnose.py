# SPDX-License-Identifier: Apache-2.0
"""Which physical effect a model lacks, and the next run.

Search, tests, verdict.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import yaml

from flatplank_analysis.cli import common, diagnose_many, loop
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.modelfile import ModelFile
from flatplank_analysis.discovery.report.text import text_of
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic
from flatplank_data.yaml_text import parse_yaml


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank diagnose DIR... [--model FILE] [--effects FILE] [--report DIR] [--json]`."""
    what = "further campaigns: each gets its diagnosis.json; further sweeps: one search"
    parser = loop.loop_parser("diagnose", __doc__, sweeps=True, more=what)
    common.parallel_arguments(parser)
    parser.add_argument("--report", metavar="DIR", help="write a page with figures there")
    parser.add_argument("--out", metavar="FILE", help="write the JSON to a file as well")
    parser.add_argument(
        "--start",
        metavar="FILE",
        help="starting values, as `flatplank calibrate sheet` prints them",
    )
    arguments = parser.parse_args(argv)
    many = arguments.more and not Path(arguments.folder).is_file()
    work = diagnose_many.run if many else _run
    return common.run_or_report_nothing_usable("diagnose", lambda: work(arguments))


def _run(arguments) -> int:
    if arguments.out:
        loop.require_file(Path(arguments.out))
    if arguments.report:
        loop.require_folder(Path(arguments.report))
    session, model = loop.open_to_look(arguments)
    measured = starting_values(arguments.start)
    result = session.diagnose(model, loop.progress, measured)
    loop.progress_done()
    if arguments.json:
        common.print_json(result.to_dict())
    else:
        print(text_of(result, arguments.folder))
    if arguments.out:
        write_atomic(Path(arguments.out), common.json_text(result.to_dict()) + "\n")
    if arguments.report:
        page = _report(arguments.report, result, session, model)
        print(f"report: {page}", file=sys.stderr if arguments.json else sys.stdout)
    return 0


def _report(folder: str, result: Diagnosis, session: Session, model: ModelFile | None) -> str:
    """Write the page; return its path, or the reason for none."""
    if result.search is None:
        return f"none, there is nothing to draw ({result.reason})"
    from flatplank_analysis.discovery.report.page import write_report

    history = model.history if model else ()
    path = session.campaign.path
    return str(write_report(result, Path(folder), path, history, session.about))


def starting_values(path: str | None) -> dict[str, dict[str, float]]:
    """Effect -> parameter -> value [SI] of a YAML file with `effects:`; empty without one."""
    if not path:
        return {}
    try:
        data = parse_yaml(Path(path).read_text(encoding="utf-8"))
        effects = data["effects"]
        return {str(e): {str(k): float(v) for k, v in p.items()} for e, p in effects.items()}
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError, AttributeError) as error:
        text = " ".join(str(error).split())
        raise FlatplankError(
            f"no starting values ({text})",
            path,
            "make them by flatplank calibrate sheet SHEET.yaml > FILE",
        ) from None
