# SPDX-License-Identifier: Apache-2.0
"""`colcon test` runs a package's tests, says where the others are, and is not green with none."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import own_tests

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "ros_ws" / "src"
EXAMPLES = {
    "flatplank_tire": "tests/tire/test_mf_structure.py",
    "flatplank_data": "tests/analysis_data/test_formats.py",
    "flatplank_hw": "tests/encoders/test_enc_core.py",
    "flatplank_control": "tests/recording/test_rec_session.py",
    "flatplank_sim": "tests/campaign/test_camp_provenance.py",
    "flatplank_panel": "tests/panel/test_panel_access.py",
    "flatplank_analysis": "tests/discovery/test_disc_effects.py",
}
"""package -> one of its tests"""


def in_folder(folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """As colcon does it: pytest without a file, in the folder of the package."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=110)


@pytest.mark.parametrize("package", EXAMPLES)
def test_every_package_has_tests_that_need_none_above_it(package):
    own = own_tests.own_tests(package)
    assert len(own) > 2
    assert {file.parent.name for file in own}.isdisjoint(own_tests.NEED_MORE)
    assert ROOT / EXAMPLES[package] in own


def test_every_package_with_code_has_tests():
    assert set(EXAMPLES) == {file.parent.name for file in SOURCES.glob("*/conftest.py")}
    assert set(EXAMPLES) == {file.parent.name for file in SOURCES.glob("*/setup.py")}


def test_a_test_of_several_packages_belongs_to_the_one_above_the_others_or_to_none():
    of_sim = ROOT / "tests/campaign/test_camp_provenance.py"
    owners = [package for package in EXAMPLES if of_sim in own_tests.own_tests(package)]
    assert owners == ["flatplank_sim"]
    of_sim_and_panel = ROOT / "tests/bench/test_limits.py"
    assert not any(of_sim_and_panel in own_tests.own_tests(package) for package in EXAMPLES)


def test_they_are_run_in_the_folder_and_the_others_are_named():
    done = in_folder(SOURCES / "flatplank_hw", "-k", "test_tare")
    assert done.returncode == 0, done.stdout
    assert "3 passed" in done.stdout
    assert "files of tests of flatplank_hw" in done.stderr
    assert f"./flatplank test in {ROOT}" in done.stderr


def test_none_at_all_is_no_success(tmp_path):
    done = in_folder(SOURCES / "flatplank_hw", "-k", "no_test_is_called_so")
    assert done.returncode == 1, done.stdout
    assert "no tests ran" in done.stdout or "deselected" in done.stdout
    alone = tmp_path / "a" / "b" / "c" / "flatplank_hw"
    alone.mkdir(parents=True)
    (alone / "conftest.py").write_text((SOURCES / "flatplank_hw" / "conftest.py").read_text())
    done = in_folder(alone)
    assert done.returncode != 0
    assert "flatplank_hw is tested in its repository" in done.stderr
