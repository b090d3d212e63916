# SPDX-License-Identifier: Apache-2.0
"""Lines of code by folder, without blank lines, docstrings, comments and imports.

python validation/benchmarks/code_lines.py [FOLDER ...]
"""

from __future__ import annotations

import ast
import io
import sys
import tokenize
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("ros_ws/src", "tests", "validation", "tools")
NO_CODE = (
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT,
    tokenize.ENDMARKER,
)  # fmt: skip


def code_lines(text: str) -> int:
    """Number of lines with code in a Python source."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    spans = [(t.start[0], t.end[0]) for t in tokens if t.type not in NO_CODE]
    lines = {n for first, last in spans for n in range(first, last + 1)}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Import, ast.ImportFrom)) or _is_text(node):
            lines -= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return len(lines)


def _is_text(node: ast.AST) -> bool:
    """True for a docstring, and for the text below a constant or a field."""
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def counted(folder: Path) -> Counter[str]:
    """Lines by the first folder below one."""
    found: Counter[str] = Counter()
    for path in folder.rglob("*.py"):
        found[path.relative_to(folder).parts[0]] += code_lines(path.read_text(encoding="utf-8"))
    return found


def main(folders: list[str]) -> int:
    for name in folders or FOLDERS:
        found = counted(ROOT / name)
        print(f"{found.total():7,}  {name}")
        for part, count in found.most_common(12):
            print(f"  {count:7,}  {part}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
