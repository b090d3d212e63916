# SPDX-License-Identifier: Apache-2.0
"""Take an effect out of the model file and refit everything."""

from __future__ import annotations

from collections.abc import Sequence

from flatplank_analysis.cli import common, loop
from flatplank_analysis.discovery.modelfile import save_unchanged


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank remove EFFECT [DIR] [--model FILE] [--json]`."""
    arguments = loop.loop_parser("remove", __doc__, effect=True).parse_args(argv)
    return common.guarded("remove", lambda: _run(arguments))


def _run(arguments) -> int:
    session, model, path = loop.open_for_change(arguments)
    loop.progress("refit of everything", 0.3)
    changed, _, numbers = session.remove(model, arguments.effect)
    loop.progress_done()
    save_unchanged(changed, path)
    if arguments.json:
        common.print_json({"model": str(path), "effect": arguments.effect, **numbers})
        return 0
    print(
        f"{arguments.effect} removed: error of Fx {numbers['rmse']:.1f} N, "
        f"floor {numbers['floor']:.1f} N; written to {path}"
    )
    return 0
