# SPDX-License-Identifier: Apache-2.0
"""Make the environment when it is missing, then run a verb in it. Standard library only; see ./flatplank.

Three things are made, each remembered by a hash of what it is made from, so that a second start only compares
hashes: the virtual environment (.venv), the ROS workspace (ros_ws/install), and the variables that sourcing both
would give (.venv/flatplank-env.json). Everything is resumable: a stamp is written last.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
WORKSPACE = ROOT / "ros_ws"
CACHE = ROOT / ".cache"
JAZZY = Path("/opt/ros/jazzy")
HAS_JAZZY = (JAZZY / "setup.bash").exists()
LOCK = ROOT / "requirements" / ("lock-jazzy.txt" if HAS_JAZZY else "lock.txt")
MESSAGES = "flatplank_msgs"
PATH_LIKE = ("PATH", "PYTHONPATH", "LD_LIBRARY_PATH", "AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH")
SYSTEM_PACKAGES = {"cc": "gcc", "c++": "g++", "make": "make", "cmake": "cmake", "ip": "iproute2"}
BUILD_TOOLS = ("cc", "c++", "make", "cmake")


class SetupError(Exception):
    """One line for the user: what, where, what to do."""


def say(text: str) -> None:
    """Progress goes to stderr: stdout belongs to the verb (`--json`)."""
    print(f"flatplank: {text}", file=sys.stderr, flush=True)


def digest(*items: Path | str) -> str:
    """Hash of files (name and content) and strings."""
    total = hashlib.sha256()
    for item in items:
        total.update(str(item).encode() + b"\0")
        if isinstance(item, Path):
            total.update(item.read_bytes())
    return total.hexdigest()[:16]


class Stamp:
    """A file that says what a step was made from."""

    def __init__(self, path: Path, *made_from: Path | str) -> None:
        self.path, self.value = path, digest(*made_from)

    def fresh(self) -> bool:
        return self.path.exists() and self.path.read_text() == self.value

    def write(self) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text(self.value)

    def clear(self) -> None:
        self.path.unlink(missing_ok=True)


def run(command: list[str], log: Path, env: dict[str, str] | None = None) -> None:
    """Run quietly, output to a log file; a failure shows its last lines."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("w") as out:
        code = subprocess.run(
            command, stdout=out, stderr=out, stdin=subprocess.DEVNULL, env=env, cwd=WORKSPACE
        ).returncode
    if code:
        raise SetupError(explain(log, command[0]))


def explain(log: Path, what: str) -> str:
    """The line of a failed step's log that says why."""
    text = log.read_text(errors="replace")
    if re.search(r"name resolution|NewConnectionError|ProxyError|Network is unreachable|Read timed out", text):
        return f"the package index cannot be reached: connect the network and start again ({log})"
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    errors = [line for line in lines if re.search(r"error", line, re.IGNORECASE)] or lines or [what]
    return f"{Path(what).name} failed: {errors[0][:300]} (all of it: {log})"


@contextmanager
def ticking(title: str, measure=None):
    """Show a step: a line that counts on a terminal, one line at its start and end elsewhere."""
    done, start, live = threading.Event(), time.monotonic(), sys.stderr.isatty()

    def tick() -> None:
        while not done.wait(0.5):
            note = f" {measure()}" if measure else ""
            print(f"\rflatplank: {title}{note} ... {time.monotonic() - start:.0f} s ", end="", file=sys.stderr)

    if not live:
        say(f"{title} ...")
    thread = threading.Thread(target=tick, daemon=True)
    if live:
        thread.start()
    try:
        yield
    finally:
        done.set()
        if live:
            thread.join()
            print("\r\033[K", end="", file=sys.stderr)
        say(f"{title}: {time.monotonic() - start:.0f} s")


@contextmanager
def only_one():
    """Two starts at once must not build into the same folders."""
    CACHE.mkdir(exist_ok=True)
    with (CACHE / "setup.lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say("another start is setting up; waiting for it")
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


# --- system packages -------------------------------------------------------------------------------------------


def missing_programs(programs=tuple(SYSTEM_PACKAGES)) -> list[str]:
    """Programs that are not on PATH; /sbin counts, where `ip` lives for root only."""
    path = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
    return [name for name in programs if not shutil.which(name, path=path)]


def install_system_packages(packages: list[str]) -> bool:
    """With apt when we are root; otherwise say the one command. True when they are there afterwards."""
    command = ["apt-get", "install", "--yes", "--no-install-recommends", *packages]
    if os.geteuid() != 0 or not shutil.which("apt-get"):
        say(f"not there: {', '.join(packages)}. To install: sudo {' '.join(command[:2] + packages)}")
        return False
    env = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    with ticking(f"system packages {' '.join(packages)}"):
        try:
            run(["apt-get", "update"], CACHE / "apt-update.log", env)
            run(command, CACHE / "apt.log", env)
        except SetupError as error:
            say(f"{error}; going on without {', '.join(packages)}")
            return False
    return True


# --- the virtual environment -----------------------------------------------------------------------------------


def site_packages() -> Path:
    found = sorted((VENV / "lib").glob("python3.*/site-packages"))
    if not found:
        raise SetupError(f"{VENV} has no site-packages: remove it and start again")
    return found[0]


def venv_stamp() -> Stamp:
    return Stamp(VENV / "flatplank.stamp", LOCK, str(ROOT), str(HAS_JAZZY))


def wanted_packages() -> int:
    here = "%d.%d" % sys.version_info[:2]
    lines = [line for line in LOCK.read_text().splitlines() if line and not line.startswith("#")]
    return sum(";" not in line or f'"{here}"' in line for line in lines)


def make_venv() -> None:
    """Create .venv and fill it from the lock; picks up where an interrupted start left it."""
    pip = [str(VENV / "bin" / "python"), "-I", "-m", "pip"]
    env = os.environ | {"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"}
    begun = Stamp(VENV / "flatplank.begun", str(ROOT), str(HAS_JAZZY))
    if not begun.fresh() or subprocess.run([*pip, "--version"], env=env, capture_output=True).returncode:
        create_venv()
        begun.write()
    forget_half_installed()
    site, total = site_packages(), wanted_packages()
    count = f"Python packages, {total} of them"
    with ticking(count, lambda: f"({len(list(site.glob('*.dist-info')))} there)"):
        options = ["--no-deps", "--no-compile", "--progress-bar", "off", "--disable-pip-version-check"]
        run([*pip, "install", *options, "-r", str(LOCK)], CACHE / "pip.log", env)
    if not HAS_JAZZY:
        repair_wheel_paths(site)


def create_venv() -> None:
    shutil.rmtree(VENV, ignore_errors=True)
    base = os.path.realpath(sys.executable)
    command = [base, "-I", "-m", "venv", str(VENV), *(["--system-site-packages"] if HAS_JAZZY else [])]
    if subprocess.run([base, "-I", "-c", "import ensurepip"], capture_output=True).returncode:
        version = "python%d.%d-venv" % sys.version_info[:2]
        if not install_system_packages([version]):
            raise SetupError(f"{base} cannot make virtual environments: install {version} and start again")
    with ticking("virtual environment .venv"):
        run(command, CACHE / "venv.log")


def forget_half_installed() -> None:
    """pip takes a package that an interruption left without its RECORD for installed: make it install again."""
    for info in site_packages().glob("*.dist-info"):
        if not (info / "RECORD").exists():
            shutil.rmtree(info)


def repair_wheel_paths(site: Path) -> None:
    """The wheels' exported cmake files carry the paths of the machine that built them."""
    ask = "import numpy, sysconfig; print(sysconfig.get_path('include')); print(numpy.get_include())"
    env = os.environ | {"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"}
    answer = subprocess.run([VENV / "bin" / "python", "-I", "-c", ask], env=env, capture_output=True, text=True)
    include, numpy = answer.stdout.split("\n")[:2]
    for file in (VENV / "share").rglob("*.cmake"):
        text = file.read_text()
        mended = re.sub(r"/opt/python/[^/]+/lib/python[\d.]+/site-packages/numpy/_core/include", numpy, text)
        mended = re.sub(r"/opt/python/[^/]+/include/python[\d.]+", include, mended)
        if mended != text:
            file.write_text(mended)


# --- the workspace ---------------------------------------------------------------------------------------------


def ros_setup() -> dict[str, str]:
    """Variables of the underlay: what colcon and the nodes need before our own packages."""
    if HAS_JAZZY:
        return sourced(JAZZY / "setup.bash", {"VIRTUAL_ENV": str(VENV), "PATH": f"{VENV}/bin:{os.defpath}"})
    libraries = [VENV / "lib", *sorted(site_packages().glob("ros_*.libs"))]
    return {
        "PATH": f"{VENV}/bin:/usr/local/bin:/usr/bin:/bin",
        "VIRTUAL_ENV": str(VENV),
        "AMENT_PREFIX_PATH": str(VENV),
        "CMAKE_PREFIX_PATH": str(VENV),
        "LD_LIBRARY_PATH": ":".join(map(str, libraries)),
        "ROS_DISTRO": "jazzy",
        "ROS_VERSION": "2",
        "ROS_PYTHON_VERSION": "3",
        # the wheels' start-up hook starts Python again to set LD_LIBRARY_PATH, unless it is told that it is set
        "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",
    }


def sourced(script: Path, env: dict[str, str]) -> dict[str, str]:
    """What `env` becomes after sourcing a script in a bash that has nothing else."""
    command = ["bash", "--norc", "-c", f". {shlex.quote(str(script))} >&2 && env -0"]
    got = subprocess.run(command, env=env, capture_output=True, cwd=ROOT)
    if got.returncode:
        raise SetupError(f"{script} cannot be sourced: {got.stderr.decode(errors='replace').strip()[-300:]}")
    pairs = (item.split("=", 1) for item in got.stdout.decode().split("\0") if "=" in item)
    return {key: value for key, value in pairs if key not in ("PWD", "SHLVL", "_", "OLDPWD")}


def package_stamps() -> dict[str, Stamp]:
    """One stamp per package of ours, over what a build reads (edits of Python code are live without a build)."""
    stamps = {}
    for package in sorted(WORKSPACE.glob("src/*/package.xml")):
        folder, name = package.parent, package.parent.name
        files = [p for pattern in ("*.xml", "*.txt", "setup.*") for p in sorted(folder.glob(pattern))]
        interfaces = [p for kind in ("msg", "srv", "action") for p in sorted(folder.glob(f"{kind}/*.{kind}"))]
        shared = [str(p) for kind in ("launch", "config") for p in sorted(folder.rglob(f"{kind}/**/*"))]
        stamps[name] = Stamp(
            WORKSPACE / "install" / name / "flatplank.stamp", *files, *interfaces, *shared, venv_stamp().value
        )
    return stamps


def build_workspace(stale: list[str]) -> list[str]:
    """colcon build of the stale packages; without a compiler the messages are left out. What was built."""
    lacking = missing_programs(BUILD_TOOLS)
    if MESSAGES in stale and lacking:
        say(f"no {', '.join(lacking)}: flatplank_msgs is not built, so no ROS graph; the rest works")
        stale = [name for name in stale if name != MESSAGES]
    if not stale:
        return []
    command = [str(VENV / "bin" / "python"), "-m", "colcon", "--log-base", str(WORKSPACE / "log"), "build"]
    command += ["--symlink-install", "--base-paths", str(WORKSPACE / "src"), "--packages-select", *stale]
    command += ["--build-base", str(WORKSPACE / "build"), "--install-base", str(WORKSPACE / "install")]
    command += ["--cmake-args", f"-DPython3_EXECUTABLE={VENV}/bin/python", "-DBUILD_TESTING=OFF", "--no-warn-unused-cli"]
    env = os.environ | ros_setup() | {"PYTHONWARNINGS": "ignore"}
    with ticking(f"ROS workspace: {' '.join(stale)}"):
        run(command, CACHE / "colcon.log", env)
    return stale


# --- all of it -------------------------------------------------------------------------------------------------


def make_all() -> dict[str, str]:
    """Make what is missing; the variables under which the verbs run."""
    environment = VENV / "flatplank-env.json"
    venv, packages = venv_stamp(), package_stamps()
    stale = [name for name, stamp in packages.items() if not stamp.fresh()]
    if venv.fresh() and not stale and environment.exists():
        return json.loads(environment.read_text())
    with only_one():
        if not venv.fresh():
            if lacking := missing_programs():
                install_system_packages(sorted({SYSTEM_PACKAGES[name] for name in lacking}))
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
        before = os.environ.get(key, "")
        # what the caller has sourced stays, behind ours and once
        kept = [part for part in before.split(":") if part and part not in value.split(":")]
        env[key] = ":".join([value, *kept]) if key in PATH_LIKE else value
    env.pop("PYTHONHOME", None)
    return env


def main(argv: list[str]) -> int:
    try:
        env = overlaid(make_all())
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
