# SPDX-License-Identifier: Apache-2.0
"""Let `colcon test` run the tests of the repository that belong to this package."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
TESTS = HERE.parents[2] / "tests"
if not (TESTS / "own_tests.py").is_file():
    sys.exit(f"{HERE.name} is tested in its repository: no tests in {TESTS}")
sys.path.insert(0, str(TESTS))
pytest_plugins = ["own_tests"]
