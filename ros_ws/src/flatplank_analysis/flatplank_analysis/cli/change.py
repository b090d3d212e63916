# SPDX-License-Identifier: Apache-2.0
"""The verbs that change the model file: `add` and `remove` refit everything, `undo` takes back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from flatplank_analysis.cli import common, loop
from flatplank_analysis.contact_patch import alternatives
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.modelfile import ModelFile, load_model, save_unchanged
from flatplank_data.arguments import Parser, add_json
from flatplank_data.wording import one_of, sized

Change = Callable[[Session, ModelFile, str], tuple[ModelFile, Any, dict[str, Any]]]
"""session, model, effect -> changed model, its fit, numbers by name"""
Words = Callable[[str, str, dict[str, Any]], str]
"""effect, force, numbers -> text for the user"""


def add(argv: Sequence[str] | None = None) -> int:
    """Put an effect into the model file and refit everything.

    What these runs cannot tell from the effect is recorded with it.
    """

    def words(effect: str, force: str, n: dict[str, Any]) -> str:
        name = one_of([effect, *(m["name"] for m in n.get("class", ()))])
        as_it = f", as {effect}" if "class" in n else ""
        return (
            f"{name}: {sized(n['size'], n['interval'], n['unit'])}{as_it}\n"
            f"error of {force} {n['rmse_before']:.1f} -> {n['rmse']:.1f} N, "
            f"held out {n['held_out']:.1f} N, floor {n['floor']:.1f} N"
        )

    return _refit("add", add.__doc__, argv, partial(Session.add, alike=None), words)


def remove(argv: Sequence[str] | None = None) -> int:
    """Take an effect out of the model file and refit everything."""

    def words(effect: str, force: str, n: dict[str, Any]) -> str:
        return f"{effect} removed: error of {force} {n['rmse']:.1f} N, floor {n['floor']:.1f} N"

    return _refit("remove", remove.__doc__, argv, Session.remove, words)


def _refit(
    verb: str, text: str | None, argv: Sequence[str] | None, change: Change, words: Words
) -> int:
    """Command line of `add` and `remove`: change the model file, refit, print; exit code.

    `flatplank VERB EFFECT [DIR] [--model FILE] [--json]`; `text` is the help text.
    """
    arguments = loop.loop_parser(verb, text, effect=True, sweeps=True).parse_args(argv)

    def work() -> int:
        session, model, path = loop.open_for_change(arguments)
        loop.progress("refit of everything", 0.3)
        changed, _, numbers = change(session, model, arguments.effect)
        loop.progress_done()
        save_unchanged(changed, path)
        if arguments.json:
            common.print_json({"model": str(path), "effect": arguments.effect, **numbers})
        else:
            print(f"{words(arguments.effect, session.force, numbers)}; written to {path}")
            for line in alternatives.words(numbers.get("class", ()), session.force):
                print(line)
            for doubt in numbers.get("doubts", ()):
                print(f"doubt: {doubt}")
        return 0

    return common.run_or_report_nothing_usable(verb, work)


def undo(argv: Sequence[str] | None = None) -> int:
    """Take back the last `add` or `remove`.

    The model file is exactly as before.
    """
    parser = Parser(prog="flatplank undo", description=undo.__doc__)
    parser.add_argument("folder", metavar="DIR", nargs="?", help="campaign folder")
    parser.add_argument("--model", metavar="FILE", help="model file (YAML)")
    add_json(parser)
    arguments = parser.parse_args(argv)
    path = loop.model_path(arguments)
    model = load_model(path)
    before = model.undone()
    save_unchanged(before, path)
    taken, now = model.history[-1], before.history[-1]
    if arguments.json:
        names = [e.name for e in before.effects]
        common.print_json(
            {"model": str(path), "undone": {k: taken[k] for k in ("action", "effect")},
             "effects": names, **{k: now.get(k) for k in ("rmse", "held_out", "floor")}}
        )  # fmt: skip
        return 0
    error = f": error {now['rmse']:.1f} N" if now.get("rmse") is not None else ""
    print(f"{taken['action']} {taken['effect']} undone{error}; written to {path}")
    return 0
