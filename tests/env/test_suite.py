# SPDX-License-Identifier: Apache-2.0
"""The suite itself: what it does not run it says, or fails; a slow test fails alone; and what is
made again was disturbed.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from stalls import ATTEMPTS, LongestWait, undisturbed

ROOT = Path(__file__).parents[2]

SKIPS = """
import pytest

@pytest.fixture
def wire():
    pytest.skip("no network namespace")

def test_one(wire): pass
def test_two(wire): pass
@pytest.mark.skip(reason="no chromium")
def test_click(): pass
@pytest.mark.long
def test_long(): pass
def test_runs(): pass
"""
SLOW = """
import subprocess, threading, time
import pytest

@pytest.fixture(scope="module")
def child():
    process = subprocess.Popen(["sleep", "600"])
    yield process
    process.kill()
    assert process.wait() == -9

@pytest.mark.timeout(0.2)
def test_sleeps(): time.sleep(600)
@pytest.mark.timeout(0.2)
def test_waits_for_a_child(child): child.wait()
@pytest.mark.timeout(0.2)
def test_waits_for_a_thread():
    threading.Thread(target=time.sleep, args=(1.0,), daemon=True).start()
    threading.enumerate()[-1].join()
def test_after(child): assert child.poll() is None
"""
DEAF = """
import signal, time
import pytest

@pytest.mark.timeout(0.2)
def test_hears_no_signal():
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGALRM})
    time.sleep(600)
"""


def suite(folder: Path, text: str, *options: str, **environment: str) -> tuple[int, str]:
    """Exit code and output of a suite of one file under this suite's rules."""
    shutil.copy(ROOT / "tests/conftest.py", folder)
    (folder / "test_made_up.py").write_text(text)
    words = [sys.executable, "-m", "pytest", "-c", str(ROOT / "pyproject.toml"), "-q"]
    words += ["--rootdir", str(folder), "-p", "no:cacheprovider", "-p", "pytest_timeout"]
    words += [*options, str(folder)]
    bare = {k: v for k, v in os.environ.items() if k != "CI"}
    bare["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    done = subprocess.run(
        words, cwd=folder, env=bare | environment, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout + done.stderr


def not_run(output: str) -> list[str]:
    section = re.search(r"^=+ not run =+\n(.*?)^(?:=|\d+ (?:passed|failed))", output, re.M | re.S)
    assert section, output
    return section[1].splitlines()


def test_the_end_says_what_was_not_run(tmp_path):
    code, output = suite(tmp_path, SKIPS)
    assert code == 0
    assert not_run(output) == [
        "2 tests: no network namespace",
        "1 test: takes minutes; runs with --long",
        "1 test: no chromium",
    ]
    assert output.splitlines()[-1].startswith("1 passed, 3 skipped, 1 deselected")


def test_the_end_says_what_was_not_reached_or_chosen(tmp_path):
    text = "def test_a(): assert 0\ndef test_b(): pass\ndef test_c(): pass\n"
    code, output = suite(tmp_path, text, "-x", "-k", "test_a or test_b")
    assert code == 1
    assert not_run(output) == [
        "1 test: not chosen by -k, -m or --deselect",
        "1 test: the run ended before them",
    ]
    code, output = suite(tmp_path, "def test_a(): pass\n")
    assert code == 0 and not_run(output) == ["nothing: all that was asked for has run"]


def test_with_ci_a_skip_is_a_failure(tmp_path):
    code, output = suite(tmp_path, SKIPS, "--long", CI="true")
    assert code == 1
    assert re.match(r"(?!.*skipped).*2 passed.*3 errors|3 failed", output.splitlines()[-1])
    assert "with CI=true everything must run: no network namespace" in output
    module = "import pytest\npytest.importorskip('no_such_module')\n"
    code, output = suite(tmp_path, module, CI="true")
    assert code != 0 and "everything must run: could not import 'no_such_module'" in output


def test_a_slow_test_fails_alone(tmp_path):
    code, output = suite(tmp_path, SLOW)
    assert code == 1
    failed = re.findall(r"^FAILED \S+::(\w+) - Failed: Timeout", output, re.M)
    assert failed == ["test_sleeps", "test_waits_for_a_child", "test_waits_for_a_thread"]
    assert output.splitlines()[-1].startswith("3 failed, 1 passed")


def test_a_test_that_hears_no_signal_ends_the_run_with_its_stack(tmp_path):
    code, output = suite(tmp_path, DEAF, FLATPLANK_TEST_GRACE="0.5")
    assert code == 1
    assert "in test_hears_no_signal" in output and "Timeout" in output


def test_only_what_a_stall_explains_is_made_again():
    made = []

    def fails(error: BaseException):
        def scenario() -> None:
            made.append(error)
            raise error

        return scenario

    for stalls, error, times in (
        (False, AssertionError("wrong"), 1),
        (True, AssertionError("late"), ATTEMPTS),
        (True, pytest.fail.Exception("not reached"), ATTEMPTS),
        (True, pytest.fail.Exception("Timeout (>3.0s) from pytest-timeout."), 1),
        (True, KeyError("a fault of the program"), 1),
        (True, KeyboardInterrupt(), 1),
    ):
        made.clear()
        with pytest.raises(type(error)):
            undisturbed(lambda stalls=stalls: stalls, fails(error))
        assert len(made) == times, error

    made.clear()
    undisturbed(lambda: True, lambda: made.append(1) if made else fails(AssertionError())())
    assert made[-1] == 1 and len(made) == 2


def test_a_stall_is_measured():
    with LongestWait() as waits:
        os.kill(waits.pid, signal.SIGSTOP)
        time.sleep(0.15)
        os.kill(waits.pid, signal.SIGCONT)
        assert waits.take() >= 0.14
        quiet = min(waits.take() for _ in range(50))
        assert quiet < 0.14, "what was told is not told again"
