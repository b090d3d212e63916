# SPDX-License-Identifier: Apache-2.0
"""The command `flatplank VERB ...`: finds the verb among the installed packages and runs it.

A verb is an entry point of the group `flatplank.verbs`: a module with `main(argv) -> exit code`.
With this package alone there are the verbs of the analysis; the bench's packages add theirs.
Exit codes: 0 done, 1 the input or the bench is at fault (one line on stderr says how), 2 nothing
could be used or the command line is wrong, 70 the program is at fault (the line names a file with
the trace), 130 stopped by Ctrl-C. A verb may give others their own meaning.
"""

from __future__ import annotations

import ast
import os
import sys
from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path

from flatplank_analysis.cli.failures import told

GROUP = "flatplank.verbs"
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Work is shared out among processes; threads of small matrices only wait for each other."""


def verbs() -> dict[str, EntryPoint]:
    """Every installed verb by name."""
    return {entry.name: entry for entry in sorted(entry_points(group=GROUP), key=lambda e: e.name)}


def summary(entry: EntryPoint) -> str:
    """First line of the verb's docstring, read without importing it: listing must not load the
    world.
    """
    spec = find_spec(entry.module)
    if spec is None or spec.origin is None:
        return "(not installed)"
    docstring = ast.get_docstring(ast.parse(Path(spec.origin).read_text(encoding="utf-8")))
    return (docstring or "").split("\n", 1)[0]


def listing(known: dict[str, EntryPoint]) -> str:
    """The help text: one line per verb."""
    lines = [f"  {name:12} {summary(entry)}" for name, entry in known.items()]
    return "\n".join(["usage: flatplank VERB [--help] ...", *lines])


def main(argv: list[str] | None = None) -> int:
    """Run one verb; bad input becomes one line on stderr."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    known = verbs()
    if not arguments or arguments[0] in ("help", "-h", "--help"):
        return guard("help", lambda: print(listing(known)) or 0)
    name, rest = arguments[0], arguments[1:]
    if name not in known:
        from flatplank_data.params import alike

        near = alike(name, known, 0.6)
        hint = f"did you mean {near[0]}?" if near else "`flatplank help` lists them"
        print(f"flatplank: no verb {name!r}: {hint}", file=sys.stderr)
        return 2
    return guard(name, lambda: int(known[name].load()(rest) or 0))


def guard(name: str, work: Callable[[], int]) -> int:
    """Exit code of `work`; whatever it raises becomes one line on stderr."""
    try:
        code = work()
        sys.stdout.flush()  # a full disk is told here, not while Python ends
        return code
    except KeyboardInterrupt as end:
        why = f" ({end})" if str(end) else ""
        print(f"flatplank {name}: stopped{why}", file=sys.stderr)
        return 130
    except BrokenPipeError:
        _drop_output()
        return 0
    except Exception as error:
        line, code = told(name, error)
        print(f"flatplank {line}", file=sys.stderr)
        if isinstance(error, OSError):
            _drop_output()
        return code


def _drop_output() -> None:
    """What stdout cannot take any more must not be tried again when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
