# SPDX-License-Identifier: Apache-2.0
"""Small faults of a Python file, made one at a time from its syntax tree.

A sign turned round, a product made a quotient, a number doubled, a comparison or a condition
reversed, `and` for `or`, a call left out. Constants of a module and the ranges and steps of
`param(...)` are not touched: `docs/reference/constants.md` has them and their own study. Nor
is what changes no number: a conversion of a type that is left out, a guard against zero that is
doubled.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

SWAPPED = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.GtE, ast.GtE: ast.LtE,
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
CONVERSIONS = ("float", "bool", "list", "tuple", "array", "asarray", "ascontiguousarray")
"""calls that give their argument back in another type"""
TINY = 1e-9
"""numbers below it stand for zero"""
WORDS = (ast.Raise, ast.JoinedStr, ast.Assert, ast.AnnAssign, ast.Import, ast.ImportFrom)
"""nothing in these changes what is computed"""


@dataclass(frozen=True)
class Mutant:
    """One fault."""

    file: str
    """relative to the package"""
    line: int
    old: str
    new: str
    source: str
    """of the whole file"""
    lines: tuple[int, ...] = ()
    """of the statement that it is in; of its head where the statement has a body"""

    @property
    def name(self) -> str:
        """For people, and for the journal."""
        old, new = (" ".join(text.split())[:60] for text in (self.old, self.new))
        return f"{self.file}:{self.line}: {old} -> {new}"


def mutants_of(path: Path, file: str) -> Iterator[Mutant]:
    """All faults of a file; its own name in the mutants is `file`."""
    text = path.read_text(encoding="utf-8")
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line.encode()))
    raw, tree = text.encode(), ast.parse(text)
    ranges = [_lines(node) for node in ast.walk(tree) if isinstance(node, ast.stmt)]
    for node, new in _changes(tree):
        a = starts[node.lineno - 1] + node.col_offset
        b = starts[node.end_lineno - 1] + node.end_col_offset
        old = raw[a:b].decode()
        word = ast.unparse(new)
        if isinstance(node, ast.expr):
            word = f"({word})"
        made = (raw[:a] + word.encode() + raw[b:]).decode()
        own = min((r for r in ranges if node.lineno in r), key=len)
        yield Mutant(file, node.lineno, old, word, made, tuple(own))


def _lines(statement: ast.stmt) -> range:
    body = getattr(statement, "body", None)
    if body and body[0].lineno > statement.lineno:
        return range(statement.lineno, body[0].lineno)
    return range(statement.lineno, statement.end_lineno + 1)


def _changes(tree: ast.Module) -> Iterator[tuple[ast.AST, ast.AST]]:
    """Nodes inside of functions, and what takes their place."""
    for function in _functions(tree):
        for statement in function.body:
            for node in _inside(statement):
                yield from _faults(node)


def _functions(node: ast.AST) -> Iterator[ast.FunctionDef]:
    """Outermost ones."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef):
            yield child
        else:
            yield from _functions(child)


def _inside(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, WORDS) or _is_text(node):
        return
    yield node
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        for child in ast.iter_child_nodes(node.value):  # the call itself is left out already
            yield from _inside(child)
        return
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "args") and isinstance(node, ast.FunctionDef):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _inside(child)


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _faults(node: ast.AST) -> Iterator[tuple[ast.AST, ast.AST]]:
    if isinstance(node, (ast.BinOp, ast.AugAssign, ast.BoolOp)) and type(node.op) in SWAPPED:
        yield node, _with(node, op=SWAPPED[type(node.op)]())
    elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in SWAPPED:
        yield node, _with(node, ops=[SWAPPED[type(node.ops[0])]()])
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not)):
        yield node, node.operand
    elif isinstance(node, ast.Constant) and _is_number(node.value):
        yield node, _with(node, value=2 * node.value if node.value else 1)
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        yield node, ast.Pass()
    elif isinstance(node, ast.Call) and _passes_on(node):
        yield node, node.args[0]
    test = getattr(node, "test", None)
    if isinstance(node, (ast.If, ast.IfExp, ast.While)) and isinstance(
        test, (ast.Name, ast.Attribute, ast.Call)
    ):
        yield test, ast.UnaryOp(ast.Not(), test)


def _passes_on(call: ast.Call) -> bool:
    """One argument, which may stand in the place of the call and is something else."""
    alone = len(call.args) == 1 and not call.keywords
    name = getattr(call.func, "attr", getattr(call.func, "id", ""))
    return alone and not isinstance(call.args[0], ast.Starred) and name not in CONVERSIONS


def _is_number(value: object) -> bool:
    """A number that is more than a guard against zero."""
    return type(value) in (int, float) and not 0.0 < abs(value) < TINY


def _with(node: ast.AST, **fields) -> ast.AST:
    new = copy.copy(node)
    for name, value in fields.items():
        setattr(new, name, value)
    return new
