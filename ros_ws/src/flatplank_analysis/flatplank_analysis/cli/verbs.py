# SPDX-License-Identifier: Apache-2.0
"""The verbs of `flatplank`: entry points, their groups, and the texts of `flatplank help`.

Of the standard library alone: a checkout that is not set up yet lists its verbs, too.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Mapping
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple, TypeGuard

PREFIX = "flatplank.verbs."
"""a verb is an entry point of `flatplank.verbs.GROUP`: a function `main(argv) -> exit code`"""


class Group(NamedTuple):
    """A part of the list of verbs."""

    title: str
    example: str


GROUPS = {
    "measure": Group("Measure, on the bench or simulated", "flatplank demo"),
    "fit": Group("Fit and report", "flatplank report mycampaign"),
    "loop": Group("Find the missing effect", "flatplank diagnose challenge"),
    "prepare": Group("Prepare the bench", "flatplank calibrate status"),
    "project": Group("This project", "flatplank doctor"),
    "benchmarks": Group("Benchmarks of this project", "flatplank bench-speed lockstep"),
}
APART = "benchmarks"
"""the group that only `flatplank help benchmarks` lists"""

Verbs = Mapping[str, EntryPoint]


def installed() -> Verbs:
    """Every installed verb by name."""
    return by_name(e for name in GROUPS for e in entry_points(group=PREFIX + name))


def by_name(entries: Iterable[EntryPoint]) -> Verbs:
    return {entry.name: entry for entry in sorted(entries, key=lambda e: e.name)}


def _source(entry: EntryPoint) -> ast.Module | None:
    """The module of a verb, read without importing it."""
    spec = find_spec(entry.module)
    if spec is None or spec.origin is None:
        return None
    return ast.parse(Path(spec.origin).read_text(encoding="utf-8"))


def _text(entry: EntryPoint, module: ast.Module) -> str:
    """Docstring of the verb's module, or of its function if that is no `main`."""
    functions = {node.name: node for node in module.body if isinstance(node, ast.FunctionDef)}
    found = module if entry.attr == "main" else functions.get(entry.attr, module)
    return ast.get_docstring(found) or ""


def summary(entry: EntryPoint) -> str:
    """What a verb does, in a line; read without importing it, because the listing must be fast."""
    module = _source(entry)
    return "(not installed)" if module is None else _text(entry, module).split("\n", 1)[0]


def described(entry: EntryPoint) -> str:
    """Text and own options of a verb as its source has them, where it cannot be imported yet."""
    module = _source(entry)
    if module is None:
        return "(not installed)"
    options = [_option(node) for node in ast.walk(module) if _adds_option(node)]
    return "\n".join(
        [
            f"usage: {_usage(entry, module)}", "", _text(entry, module), "",
            *(f"  {name:17} {text}" for name, text in options if name), "",
            f"`flatplank {entry.name} --help` has every option when the project is set up; the "
            "first run of a verb does that.",
        ]
    )  # fmt: skip


def _usage(entry: EntryPoint, module: ast.Module) -> str:
    """The call of a verb as the docstring of its function has it."""
    functions = [n for n in module.body if isinstance(n, ast.FunctionDef) and n.name == entry.attr]
    text = " ".join(" ".join(ast.get_docstring(f) or "" for f in functions).split())
    found = re.search(rf"`(flatplank {re.escape(entry.name)} [^`]*)`", text)
    return found[1] if found else f"flatplank {entry.name} [OPTIONS] ..."


def _adds_option(node: ast.AST) -> TypeGuard[ast.Call]:
    return (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and node.func.attr == "add_argument"
    )


def _option(call: ast.Call) -> tuple[str, str]:
    """Name and help of an option; empty where the source computes them."""
    values = {k.arg: k.value for k in call.keywords}
    given = {k: v.value for k, v in values.items() if isinstance(v, ast.Constant)}
    words = [a.value for a in call.args if isinstance(a, ast.Constant)]
    names = [word for word in words if isinstance(word, str)]
    name = names[-1] if names else ""
    if not name.startswith("-"):
        name = str(given.get("metavar") or name)
    elif given.get("metavar"):
        name += f" {given['metavar']!s}"
    return name, str(given.get("help") or "")


def listing(known: Verbs, groups: Iterable[str] = ()) -> str:
    """A line per verb, in groups with an example each; without `groups` those for users."""
    lines = ["usage: flatplank VERB [OPTIONS] ...      flatplank help VERB: its options"]
    for name in groups or (name for name in GROUPS if name != APART):
        members = [e for e in known.values() if e.group == PREFIX + name]
        if members:
            title, example = GROUPS[name]
            lines += ["", f"{title}, for instance: {example}"]
            lines += [f"  {e.name:17} {summary(e)}" for e in members]
    if not groups and any(e.group == PREFIX + APART for e in known.values()):
        lines += ["", f"flatplank help {APART} lists the {APART}."]
    return "\n".join(lines)
