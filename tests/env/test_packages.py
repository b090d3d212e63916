# SPDX-License-Identifier: Apache-2.0
"""The ROS packages: what they declare, what is in them and what gets installed agree."""

from __future__ import annotations

import ast
import configparser
import importlib.metadata
import importlib.util
import os
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "ros_ws" / "src"
INSTALL = ROOT / "ros_ws" / "install"
PACKAGES = sorted(path.parent.name for path in SOURCES.glob("*/package.xml"))
PYTHON_PACKAGES = [name for name in PACKAGES if (SOURCES / name / "setup.py").exists()]
KEYS = {"control": "python-control-pip", "rosbags": "python3-rosbags-pip"} | {
    name: f"python3-{name}"
    for name in ("h5py", "jinja2", "matplotlib", "numba", "numpy", "pandas", "scipy", "yaml")
}
"""import -> its key of rosdep on Ubuntu 24.04 (rosdistro, rosdep/python.yaml)"""
FROM_PYPI_ALONE = {"lz4", "markupsafe", "mcap", "nicegui", "pyarrow", "pysoem", "zstandard"}
"""imports that rosdep does not know on Ubuntu 24.04: setup.cfg requires them"""

DISTRIBUTIONS = {"yaml": "pyyaml"}
"""Where the name of the distribution is not that of the module."""


def manifest(package: str) -> ElementTree.Element:
    return ElementTree.parse(SOURCES / package / "package.xml").getroot()


def dependencies(package: str) -> set[str]:
    return {e.text or "" for e in manifest(package) if e.tag in ("depend", "exec_depend")}


def setup_values(package: str) -> dict[str, object]:
    """What setup.cfg declares; `NODES` are the programs that `ros2 run` finds."""
    file = configparser.ConfigParser()
    file.read(SOURCES / package / "setup.cfg", encoding="utf-8")

    def several(section: str, key: str) -> list[str]:
        return [text for text in re.split(r"[\n;] *", file.get(section, key, fallback="")) if text]

    extras, points = "options.extras_require", "options.entry_points"
    runs = file["install"]["install_scripts"] == f"$base/lib/{package}"
    return {
        **file["metadata"],
        "install_requires": several("options", "install_requires"),
        "extras_require": {name: several(extras, name) for name in file[extras]},
        "NODES": several(points, "console_scripts") if runs else [],
        "VERBS": [
            verb
            for group in (file[points] if file.has_section(points) else ())
            if group.startswith("flatplank.verbs.")
            for verb in several(points, group)
        ],
    }


def imported_modules(package: str) -> set[str]:
    """Top-level names that the package's code imports, conditional ones included."""
    found = set()
    for file in (SOURCES / package / package).rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                found |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                found.add(node.module.split(".")[0])
    return found


def test_the_packages_are_there() -> None:
    assert PACKAGES == [
        "flatplank_analysis",
        "flatplank_control",
        "flatplank_data",
        "flatplank_hw",
        "flatplank_msgs",
        "flatplank_panel",
        "flatplank_sim",
        "flatplank_tire",
    ]


@pytest.mark.parametrize("package", PACKAGES)
def test_manifest(package: str) -> None:
    root = manifest(package)
    assert root.get("format") == "3"
    assert root.findtext("name") == package
    assert root.findtext("license") == "Apache-2.0"
    maintainer = root.find("maintainer")
    assert maintainer is not None
    assert re.fullmatch(r"[\w.-]+@[\w-]+(\.[\w-]+)+", maintainer.get("email", ""))


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_setup_agrees_with_the_manifest(package: str) -> None:
    values, root = setup_values(package), manifest(package)
    assert values["name"] == package
    assert values["version"] == root.findtext("version")
    assert values["license"] == root.findtext("license")
    assert (SOURCES / package / "resource" / package).exists()


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_every_import_is_declared(package: str) -> None:
    declared, imported = dependencies(package), imported_modules(package)
    ros = {name for name in imported if (INSTALL / name).exists() or name in _ros_modules()}
    optional = {n for names in setup_values(package)["extras_require"].values() for n in names}
    own = imported - ros - {package} - set(sys.stdlib_module_names) - (optional - {"pysoem"})
    assert own <= KEYS.keys() | FROM_PYPI_ALONE
    wanted = {KEYS[name] for name in own - FROM_PYPI_ALONE}
    assert wanted | (ros - {package}) <= declared
    assert {key for key in declared if key.startswith("python")} <= wanted


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_every_pip_import_is_required(package: str) -> None:
    values = setup_values(package)
    extras = {n for e, names in values["extras_require"].items() if e != "test" for n in names}
    required = {re.split(r"[\[<>=; ]", name)[0] for name in values["install_requires"]}
    listed = _inputs("runtime.in") | _inputs("panel.in")
    known = set(sys.stdlib_module_names) | _ros_modules() | set(PACKAGES)
    pip = {DISTRIBUTIONS.get(name, name) for name in imported_modules(package) - known}
    assert pip <= required | extras
    assert required <= listed | set(PACKAGES)
    # an extra that the environment does not have is one that the tests have
    assert extras <= listed | _inputs("test.in")


def _inputs(file: str) -> set[str]:
    lines = (ROOT / "requirements" / file).read_text().splitlines()
    return {re.split(r"[\[<>=; ]", line)[0] for line in lines if line and line[0] != "#"}


def _ros_modules() -> set[str]:
    """Importable packages that ROS provides, by the ament index."""
    prefixes = os.environ["AMENT_PREFIX_PATH"].split(os.pathsep)
    index = (Path(p, "share", "ament_index", "resource_index", "packages") for p in prefixes)
    return {marker.name for folder in index if folder.is_dir() for marker in folder.iterdir()}


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_every_entry_point_leads_to_a_function(package: str) -> None:
    values = setup_values(package)
    entries = [*values.get("NODES", []), *values.get("VERBS", [])]
    for entry in entries:
        match = re.fullmatch(r"([a-z_-]+) = ([\w.]+):(\w+)", entry)
        assert match, entry
        module, function = match[2], match[3]
        if module == f"{package}.start":  # which imports the node (tests/env/test_programs.py)
            module, function = f"{package}.nodes.{function}", "main"
        spec = importlib.util.find_spec(module)
        assert spec is not None and spec.origin is not None, entry
        functions = ast.parse(Path(spec.origin).read_text()).body
        assert function in {getattr(node, "name", "") for node in functions}, entry


@pytest.mark.parametrize("package", PACKAGES)
def test_installed_where_ros_looks(package: str) -> None:
    prefix = INSTALL / package
    assert (prefix / "share/ament_index/resource_index/packages" / package).exists()
    assert (prefix / "share" / package / "package.xml").exists()
    for kind in ("launch", "config"):
        wanted = [f for f in (SOURCES / package / kind).rglob("*") if f.is_file()]
        for file in wanted:
            relative = file.relative_to(SOURCES / package)
            if "__pycache__" not in relative.parts:
                assert (prefix / "share" / package / relative).exists(), relative


@pytest.mark.parametrize("package", PYTHON_PACKAGES)
def test_nodes_are_where_ros2_run_looks(package: str) -> None:
    for entry in setup_values(package).get("NODES", []):
        script = INSTALL / package / "lib" / package / entry.split(" = ")[0]
        assert os.access(script, os.X_OK), script


def test_every_verb_is_known_and_explains_itself() -> None:
    from flatplank_analysis.cli.verbs import installed, listing, summary

    registered = {
        entry.split(" = ")[0]
        for p in PYTHON_PACKAGES
        for entry in setup_values(p).get("VERBS", [])
    }
    known = installed()
    assert registered <= known.keys()
    for name, entry in known.items():
        assert len(summary(entry)) > 10, name
    text = "\n".join([listing(known), listing(known, ["benchmarks"])])
    assert max(map(len, text.splitlines())) <= 80, "a terminal"
    assert {line.split()[0] for line in text.splitlines() if line.startswith("  ")} == set(known)


def test_every_number_in_a_message_says_its_unit() -> None:
    bare = [
        f"{file.name}: {line}"
        for kind in ("msg", "srv", "action")
        for file in sorted((SOURCES / "flatplank_msgs").glob(f"{kind}/*.{kind}"))
        for line in file.read_text().splitlines()
        if re.match(r"u?(int|float)\d+\S* +[a-z]", line) and "#" not in line
    ]
    assert bare == []


def test_packages_of_the_lock_are_the_installed_ones() -> None:
    jazzy = Path("/opt/ros/jazzy/setup.bash").exists()
    text = (ROOT / "requirements" / ("lock-jazzy.txt" if jazzy else "lock.txt")).read_text()
    for name in ("numpy", "scipy", "numba", "rosbags", "mcap"):
        assert f"{name}=={importlib.metadata.version(name)}" in text
