# SPDX-License-Identifier: Apache-2.0
"""What `colcon test` runs here: the tests of the repository that need this package only."""

import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
TESTS = HERE.parents[2] / "tests"
sys.path.insert(0, str(TESTS))


def pytest_configure(config):
    if not (TESTS / "own_tests.py").is_file():
        raise pytest.UsageError(f"{HERE.name} is tested in its repository: no tests in {TESTS}")
    from own_tests import choose

    choose(config, HERE.name)


def pytest_sessionfinish(session, exitstatus):
    if exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED  # nothing tested is not green


def pytest_unconfigure():
    from own_tests import where_the_others_are

    # colcon shows what goes there, and hides the rest
    print(where_the_others_are(HERE.name), file=sys.stderr)
