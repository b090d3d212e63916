# SPDX-License-Identifier: Apache-2.0
"""Where a model fails: error beside the noise floor.

By condition and over the coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence

from flatplank_analysis.cli import common, loop
from flatplank_analysis.contact_patch import comparison


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank compare DIR [--model FILE] [--json]`; without FILE DIR/model.yaml, if any."""
    arguments = loop.loop_parser("compare", __doc__, sweeps=True).parse_args(argv)
    return common.run_or_report_nothing_usable("compare", lambda: _run(arguments))


def _run(arguments) -> int:
    session, model = loop.open_to_look(arguments, own=True)
    loop.progress("fit", 0.3)
    step = session.fit(model)
    loop.progress_done()
    data = comparison.numbers(session, step)
    if arguments.json:
        common.print_json(data)
    else:
        print(comparison.text_of(data))
    return 0
