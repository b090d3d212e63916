# SPDX-License-Identifier: Apache-2.0
"""Make the environment when it is missing, then run a verb in it. Standard library only.

What is made is remembered by hashes of what it is made from, so that a second start only compares
hashes: the virtual environment with the sections of the lock (.venv), the ROS workspace
(ros_ws/install), and the variables that sourcing both would give (.venv/flatplank-env.json).
Everything is resumable: a stamp is written last.
"""

from __future__ import annotations

import json
import os
import shlex
import sys
import time
from pathlib import Path

from common import (
    CACHE,
    PATH_LIKE,
    ROOT,
    SYSTEM_PATH,
    TIMES,
    VALIDATION,
    VENV,
    WORKSPACE,
    SetupError,
    one_line,
    only_one,
    run,
    say,
    side_by_side,
    ticking,
    trace_of,
)
from source import needs_no_setup, run_from_source
from system import install_system_packages, make_ready_for, missing_packages
from virtual import (
    FIRST,
    MORE,
    install,
    installed_of,
    locked,
    make_venv,
    section_stamp,
    venv_stamp,
)
from workspace import MESSAGES, build, package_stamps, ros_setup, sourced, without_compiler

ENVIRONMENT = VENV / "flatplank-env.json"


def make_all(verb: str) -> dict[str, str]:
    """Make what is missing; the variables under which the verbs run."""
    sections = (*FIRST, *MORE.get(verb, ()))
    if not missing(sections):
        return json.loads(ENVIRONMENT.read_text())
    with only_one():
        leave_venv()
        if missing(FIRST):
            make_first()
        for section in filter(section_is_missing, sections):
            with ticking(f"{len(locked(section))} more Python packages for {verb}"):
                install(section)
    return json.loads(ENVIRONMENT.read_text())


def missing(sections: tuple[str, ...]) -> bool:
    """Whether there is anything to make."""
    if not (venv_stamp().fresh() and ENVIRONMENT.exists()):
        return True
    return bool(stale_packages()) or any(map(section_is_missing, sections))


def section_is_missing(name: str) -> bool:
    return not section_stamp(name).fresh()


def stale_packages() -> list[str]:
    """Packages of the workspace that are to be built."""
    return [name for name, stamp in package_stamps().items() if not stamp.fresh()]


def leave_venv() -> None:
    """Go on under the Python that .venv was made from: .venv may have to go."""
    if not venv_stamp().fresh() and VENV in Path(sys.executable).parents:
        say("this folder was copied or moved, or its Python is another: .venv is made anew")
        base = os.path.realpath(sys.executable)
        os.execv(base, [base, "-E", "-s", "-S", str(ROOT / "tools" / "setup"), *sys.argv[1:]])


def make_first() -> None:
    """What every verb needs; what does not need each other is made side by side."""
    begin = time.monotonic()
    if not venv_stamp().fresh() and (lacking := missing_packages()):
        install_system_packages(lacking)
    with ticking("step 1 of 3, virtual environment .venv"):
        make_venv()
    with ticking(f"step 2 of 3, {len(locked('workspace'))} packages of ROS and its tools"):
        if section_is_missing("workspace"):
            install("workspace")
    stale = without_compiler(stale_packages())
    wanted = locked("workspace") | locked("main")
    step = f"step 3 of 3, {len(locked('main'))} Python packages, ROS workspace {' '.join(stale)}"
    with ticking(step, lambda: f"({installed_of(wanted)} of {len(wanted)})"):
        side_by_side(lambda: build([MESSAGES] if MESSAGES in stale else []), lambda: rest(stale))
        warm_up("modules")
        ENVIRONMENT.write_text(json.dumps(variables(), indent=1))
    TIMES.write_text(json.dumps({"set-up": time.monotonic() - begin}))


def rest(stale: list[str]) -> None:
    """All but the messages, which take longest."""
    python = [name for name in stale if name != MESSAGES]

    def main_packages() -> None:
        if section_is_missing("main"):
            install("main")

    side_by_side(main_packages, lambda: build(python))
    warm_up("kernels")


def warm_up(what: str) -> None:
    """Byte code and machine code, which the first nodes would all make at once.

    A failure only costs time later; it stands in the log.
    """
    command = [str(VENV / "bin" / "python"), str(ROOT / "tools" / "setup" / "warm.py"), what]
    try:
        run(command, CACHE / f"warm-{what}.log", overlaid(variables()))
    except SetupError as error:
        say(f"{one_line(error)}; the first start will take longer")


def variables() -> dict[str, str]:
    """What sourcing the underlay and the workspace gives."""
    overlay = WORKSPACE / "install" / "local_setup.bash"
    return sourced(overlay, ros_setup()) if overlay.exists() else ros_setup()


def overlaid(variables: dict[str, str]) -> dict[str, str]:
    """The caller's environment with ours in front."""
    env = dict(os.environ) | {"NUMBA_CACHE_DIR": str(CACHE / "numba"), "FLATPLANK_ROOT": str(ROOT)}
    ours_too = {"PYTHONPATH": f"{variables.get('PYTHONPATH', '')}:{VALIDATION}".lstrip(":")}
    for key, value in (variables | ours_too).items():
        if key in PATH_LIKE:
            # what the caller has sourced stays, behind ours and once
            ours = [part for part in value.split(":") if part not in SYSTEM_PATH]
            theirs = os.environ.get(key, "").split(":")
            value = ":".join(ours + [part for part in theirs if part and part not in ours])
        env[key] = value
    env.pop("PYTHONHOME", None)
    return env


def main(argv: list[str]) -> int:
    """Become the verb; what keeps it from that is one line and an exit code."""
    verb = (argv or ["help"])[0]
    if needs_no_setup(argv) and missing(FIRST):
        return run_from_source(argv)
    try:
        env = overlaid(make_all(verb))
        make_ready_for(verb)
    except SetupError as error:
        say(str(error))
        return 1
    except KeyboardInterrupt:
        say("stopped; start again to go on from here")
        return 130
    except OSError as error:
        say(one_line(error))
        return 1
    except Exception as error:
        say(f"set-up, unexpected {one_line(error)}; please report it with {trace_of(error)}")
        return 70
    if verb == "env":
        ours = {k: v for k, v in env.items() if os.environ.get(k) != v}
        print("\n".join(f"export {k}={shlex.quote(v)}" for k, v in sorted(ours.items())))
        return 0
    python = str(VENV / "bin" / "python")
    script = str(WORKSPACE / "install" / "flatplank_analysis" / "bin" / "flatplank")
    os.execve(python, [python, script, *(argv or ["help"])], env)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
