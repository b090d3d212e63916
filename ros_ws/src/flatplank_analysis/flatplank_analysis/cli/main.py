# SPDX-License-Identifier: Apache-2.0
"""The command `flatplank VERB ...`: finds the verb among the installed packages and runs it.

With this package alone there are the verbs of the analysis; the bench's packages add theirs.
Exit codes: 0 done, 1 the input or the bench is at fault (one line on stderr says how), 2 nothing
could be used or the command line is wrong, 70 the program is at fault (the line names a file with
the trace), 130 stopped by Ctrl-C. A verb may give others their own meaning.
"""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable
from importlib.metadata import version

from flatplank_analysis.cli.verbs import GROUPS, Verbs, described, installed, listing
from flatplank_data.names import similar_names
from flatplank_data.traces import keep_trace

HELP = ("help", "-h", "--help")

AT_FAULT = 1
"""The input, the computer or the bench is at fault; the line names the remedy."""

UNEXPECTED = 70
"""The program is at fault (EX_SOFTWARE of sysexits.h); the line names the file of the trace."""

REMEDIES = {
    errno.ENOSPC: "free some space, or name a folder on another disk",
    errno.EDQUOT: "free some of your quota, or name a folder on another disk",
    errno.EFBIG: "raise the limit of file sizes (ulimit -f)",
    errno.EROFS: "name a folder that can be written",
    errno.EACCES: "name a folder that is yours, or get the permission",
    errno.EPERM: "get the permission",
    errno.EADDRINUSE: "end the program that has it, or name another port",
    errno.EMFILE: "raise the limit of open files (ulimit -n)",
    errno.ENOENT: "",
    errno.ENOTDIR: "",
    errno.EISDIR: "",
    errno.EEXIST: "",
}
"""System errors that the user can correct, with the remedy."""


def error_line(verb: str, error: BaseException) -> tuple[str, int]:
    """The line for the user and the exit code."""
    known = _known(error)
    if known is not None:
        return f"{verb}: {_one_line(known)}", AT_FAULT
    what = f"unexpected {type(error).__name__}: {_one_line(str(error)) or 'no message'}"
    file = keep_trace(error)
    where = f"please report it with {file}" if file else "its trace could not be written anywhere"
    return f"{verb}: {what}; {where}", UNEXPECTED


def _known(error: BaseException) -> str | None:
    """Text for a foreseen failure; None for others."""
    if isinstance(error, ValueError):  # FlatplankError is one
        return str(error)
    if isinstance(error, OSError) and error.errno in REMEDIES:
        place = f"{error.filename}: " if error.filename else ""
        remedy = REMEDIES[error.errno]
        return f"{place}{error.strerror}" + (f"; {remedy}" if remedy else "")
    if isinstance(error, FileNotFoundError):  # without errno: raised by us, text for users
        return str(error)
    if isinstance(error, ImportError):
        return f"{error}; ./flatplank doctor says what is missing"
    if isinstance(error, MemoryError):
        return "not enough memory; --jobs 1 needs less where it is an option"
    if any(kind.__name__ == "BrokenExecutor" for kind in type(error).__mro__):
        return "a process of the calculation was killed, often for want of memory; try --jobs 1"
    return None


def _one_line(text: str) -> str:
    return " ".join(text.split())


ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Work is distributed over processes; threads for small matrices only wait for each other."""


def main(
    argv: list[str] | None = None, known: Verbs | None = None, release: str | None = None
) -> int:
    """Run one verb; bad input becomes one line on stderr.

    `known`, `release`: verbs and version, by default those of the installed packages.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    known = installed() if known is None else known
    verb, rest = (arguments or ["help"])[0], arguments[1:]
    if verb in HELP:
        return run_reporting_errors("help", lambda: _help(known, rest))
    if verb == "--version":
        print(f"flatplank {release or version('flatplank_analysis')}")
        return 0
    if verb not in known:
        return _unknown(verb, known)
    if rest and rest[0] in HELP[1:]:
        return run_reporting_errors(verb, lambda: _help(known, [verb]))
    return run_reporting_errors(verb, lambda: int(known[verb].load()(rest) or 0))


def _help(known: Verbs, words: list[str]) -> int:
    """The list of verbs, of a group, or the options of a verb."""
    if not words or words[0] in GROUPS:
        print(listing(known, words))
        return 0
    if words[0] not in known:
        return _unknown(words[0], known)
    entry = known[words[0]]
    try:
        verb = entry.load()
    except ImportError:  # before the set-up
        print(described(entry))
        return 0
    return int(verb(["--help"]) or 0)


def _unknown(verb: str, known: Verbs) -> int:
    near = similar_names(verb, known, 0.6)
    hint = f"did you mean {near[0]}?" if near else "`flatplank help` lists them"
    print(f"flatplank: no verb {verb!r}: {hint}", file=sys.stderr)
    return 2


def run_reporting_errors(name: str, work: Callable[[], int]) -> int:
    """Exit code of `work`; whatever it raises becomes one line on stderr."""
    try:
        code = work()
        sys.stdout.flush()  # reports a full disk here, not while Python ends
        return code
    except KeyboardInterrupt as end:
        why = f" ({end})" if str(end) else ""
        print(f"flatplank {name}: stopped{why}", file=sys.stderr)
        return 130
    except BrokenPipeError:
        _drop_output()
        return 0
    except Exception as error:
        line, code = error_line(name, error)
        print(f"flatplank {line}", file=sys.stderr)
        if isinstance(error, OSError):
            _drop_output()
        return code


def _drop_output() -> None:
    """Discard output that stdout cannot accept, so that Python does not retry at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
