# SPDX-License-Identifier: Apache-2.0
"""Put an effect into the model file and refit everything jointly."""

from __future__ import annotations

from collections.abc import Sequence

from flatplank_analysis.cli import common, loop
from flatplank_analysis.discovery.modelfile import save_unchanged
from flatplank_analysis.wording import sized


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank add EFFECT [DIR] [--model FILE] [--json]`."""
    arguments = loop.loop_parser("add", __doc__, effect=True).parse_args(argv)
    return common.guarded("add", lambda: _run(arguments))


def _run(arguments) -> int:
    session, model, path = loop.open_for_change(arguments)
    loop.progress("refit of everything", 0.3)
    changed, _, numbers = session.add(model, arguments.effect)
    loop.progress_done()
    save_unchanged(changed, path)
    if arguments.json:
        common.print_json({"model": str(path), "effect": arguments.effect, **numbers})
        return 0
    print(
        f"{arguments.effect}: {sized(numbers['size'], numbers['interval'], numbers['unit'])}\n"
        f"error of Fx {numbers['rmse_before']:.1f} -> {numbers['rmse']:.1f} N, "
        f"held out {numbers['held_out']:.1f} N, floor {numbers['floor']:.1f} N; written to {path}"
    )
    for doubt in numbers["doubts"]:
        print(f"doubt: {doubt}")
    return 0
