# SPDX-License-Identifier: Apache-2.0
"""What a repair changed: a campaign before it, and one after.

Sizes of the effects, errors by condition, and what else changed in the tire.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from flatplank_analysis.cli import common, loop
from flatplank_analysis.contact_patch import repair
from flatplank_analysis.discovery.modelfile import Entry, ModelFile, load_model
from flatplank_data.arguments import Parser, add_json
from flatplank_data.errors import FlatplankError


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank repair BEFORE AFTER [EFFECT...] [--figure FILE] [--json]`."""
    parser = Parser(prog="flatplank repair", description=__doc__)
    parser.add_argument("before", metavar="BEFORE", help="campaign folder before the repair")
    parser.add_argument("after", metavar="AFTER", help="campaign folder after it, same conditions")
    parser.add_argument("effect", metavar="EFFECT", nargs="*",
                        help="what was repaired; default: all of BEFORE/model.yaml")  # fmt: skip
    parser.add_argument(
        "--figure", metavar="FILE", help="picture of the condition that changed most (.png)"
    )
    common.effect_arguments(parser)
    add_json(parser)
    common.mapping_argument(parser)
    arguments = parser.parse_args(argv)
    return common.run_or_report_nothing_usable("repair", lambda: _run(arguments))


def _run(arguments: argparse.Namespace) -> int:
    model = _model(arguments)
    if arguments.figure:
        loop.require_file(Path(arguments.figure))
    sides = []
    for share, folder in ((0.05, arguments.before), (0.5, arguments.after)):
        session = loop.session_of(arguments, folder, model)
        loop.progress(f"fits of {folder}", share)
        sides.append(repair.Side.of(session, [e.name for e in model.effects]))
    loop.progress_done()
    data = repair.numbers(*sides)
    if arguments.figure:
        from flatplank_analysis.discovery.report.figures import png
        from flatplank_analysis.discovery.report.repair import figure_of_repair

        drawn = figure_of_repair(*(side.bare.state for side in sides))
        Path(arguments.figure).write_bytes(png(drawn))
    if arguments.json:
        common.print_json(data)
    else:
        print(repair.text_of(data))
    return 0


def _model(arguments: argparse.Namespace) -> ModelFile:
    """The effects that are compared, with the files that define them."""
    if arguments.effect:
        return ModelFile(effects=tuple(map(Entry, dict.fromkeys(arguments.effect))))
    path = Path(arguments.before) / loop.MODEL
    model = load_model(path) if path.is_file() else ModelFile()
    if not model.effects:
        what = "no effect to compare by"
        raise FlatplankError(what, arguments.before, "name what was repaired: EFFECT")
    return model
