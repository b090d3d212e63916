# SPDX-License-Identifier: Apache-2.0
"""Make the environment when it is missing, then run a verb in it. Standard library only.

Three things are made, each remembered by a hash of what it is made from, so that a second start
only compares hashes: the virtual environment (.venv), the ROS workspace (ros_ws/install), and the
variables that sourcing both would give (.venv/flatplank-env.json). Everything is resumable: a
stamp is written last.
"""

from __future__ import annotations

import json
import os
import shlex
import sys

from common import CACHE, PATH_LIKE, ROOT, SYSTEM_PATH, VENV, WORKSPACE, SetupError, only_one, say
from system import install_system_packages, make_ready_for, missing_packages
from virtual import make_venv, venv_stamp
from workspace import build_workspace, package_stamps, ros_setup, sourced


def make_all() -> dict[str, str]:
    """Make what is missing; the variables under which the verbs run."""
    environment = VENV / "flatplank-env.json"
    venv, packages = venv_stamp(), package_stamps()
    stale = [name for name, stamp in packages.items() if not stamp.fresh()]
    if venv.fresh() and not stale and environment.exists():
        return json.loads(environment.read_text())
    with only_one():
        if not venv.fresh():
            if lacking := missing_packages():
                install_system_packages(lacking)
            make_venv()
            venv.write()
        stale = [name for name, stamp in package_stamps().items() if not stamp.fresh()]
        for name in build_workspace(stale):
            packages[name].write()
        variables = ros_setup()
        overlay = WORKSPACE / "install" / "local_setup.bash"
        if overlay.exists():
            variables = sourced(overlay, variables)
        environment.write_text(json.dumps(variables, indent=1))
    return variables


def overlaid(variables: dict[str, str]) -> dict[str, str]:
    """The caller's environment with ours in front."""
    env = dict(os.environ) | {"NUMBA_CACHE_DIR": str(CACHE / "numba"), "FLATPLANK_ROOT": str(ROOT)}
    for key, value in variables.items():
        if key in PATH_LIKE:
            # what the caller has sourced stays, behind ours and once
            ours = [part for part in value.split(":") if part not in SYSTEM_PATH]
            theirs = os.environ.get(key, "").split(":")
            value = ":".join(ours + [part for part in theirs if part and part not in ours])
        env[key] = value
    env.pop("PYTHONHOME", None)
    return env


def main(argv: list[str]) -> int:
    try:
        env = overlaid(make_all())
        make_ready_for(*argv[:1] or ["help"])
    except SetupError as error:
        say(str(error))
        return 1
    except KeyboardInterrupt:
        say("stopped; start again to go on from here")
        return 130
    if argv[:1] == ["env"]:
        ours = {k: v for k, v in env.items() if os.environ.get(k) != v}
        print("\n".join(f"export {k}={shlex.quote(v)}" for k, v in sorted(ours.items())))
        return 0
    python = str(VENV / "bin" / "python")
    script = str(WORKSPACE / "install" / "flatplank_analysis" / "bin" / "flatplank")
    os.execve(python, [python, script, *(argv or ["help"])], env)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
