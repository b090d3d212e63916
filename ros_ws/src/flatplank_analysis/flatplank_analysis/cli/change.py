# SPDX-License-Identifier: Apache-2.0
"""What `add` and `remove` have in common: change the model file and refit everything."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from flatplank_analysis.cli import common, loop
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.modelfile import ModelFile, save_unchanged

Change = Callable[[Session, ModelFile, str], tuple[ModelFile, Any, dict[str, Any]]]
"""session, model, effect -> changed model, its fit, numbers by name"""
Words = Callable[[str, dict[str, Any], Path], str]
"""effect, numbers, model file -> what is told"""


def run(
    verb: str, text: str | None, argv: Sequence[str] | None, change: Change, words: Words
) -> int:
    """Run one of the two verbs; its exit code."""
    arguments = loop.loop_parser(verb, text, effect=True).parse_args(argv)
    return common.guarded(verb, lambda: _run(arguments, change, words))


def _run(arguments: Namespace, change: Change, words: Words) -> int:
    session, model, path = loop.open_for_change(arguments)
    loop.progress("refit of everything", 0.3)
    changed, _, numbers = change(session, model, arguments.effect)
    loop.progress_done()
    save_unchanged(changed, path)
    if arguments.json:
        common.print_json({"model": str(path), "effect": arguments.effect, **numbers})
    else:
        print(words(arguments.effect, numbers, path))
    return 0
