# SPDX-License-Identifier: Apache-2.0
"""The verbs of `flatplank`: entry points, their groups, and the texts of `flatplank help`.

Of the standard library alone: a checkout that is not set up yet lists its verbs, too.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

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


def summary(entry: EntryPoint) -> str:
    """First line of the docstring of the verb's module, or of its function if that is no `main`.

    Read without importing it, because the listing must be fast.
    """
    spec = find_spec(entry.module)
    if spec is None or spec.origin is None:
        return "(not installed)"
    module = ast.parse(Path(spec.origin).read_text(encoding="utf-8"))
    functions = {node.name: node for node in module.body if isinstance(node, ast.FunctionDef)}
    found = module if entry.attr == "main" else functions.get(entry.attr, module)
    return (ast.get_docstring(found) or "").split("\n", 1)[0]


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
