# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from setuptools import find_namespace_packages, setup

NAME = "flatplank_control"
# One line per node: `ros2 run flatplank_control NAME`.
NODES = [
    "free_rolling_controller = flatplank_control.start:free_rolling_controller",
    "slip_sequencer = flatplank_control.start:slip_sequencer",
    "recorder = flatplank_control.start:recorder",
    "measurement_runner = flatplank_control.start:measurement_runner",
    "load_controller = flatplank_control.start:load_controller",
    "axis_hold = flatplank_control.start:axis_hold",
]
# One line per verb of the command `flatplank`: a module with `main(argv) -> exit code`; the first
# line of its docstring is the help.
VERBS = [
    "bench = flatplank_control.cli.bench:main",
    "slip = flatplank_control.cli.slip:main",
    "run = flatplank_control.cli.run:main",
    "investigate = flatplank_control.cli.investigate:main",
    "tune = flatplank_control.cli.tune:main",
    "calibrate = flatplank_control.cli.calibrate:main",
    "road-map = flatplank_control.cli.road_map:main",
    "doctor = flatplank_control.cli.doctor:main",
    "test = flatplank_control.cli.test:main",
]


def shared(*folders):
    """Files of these folders, to be installed under share/<package> at the same relative path."""
    files = (path for folder in folders for path in Path(folder).rglob("*") if path.is_file())
    return [(f"share/{NAME}/{path.parent}", [str(path)]) for path in sorted(files)]


setup(
    name=NAME,
    version="0.1.0",
    description="Controllers, recorder and measurement runner of the flat plank bench.",
    maintainer="Flat Plank maintainers",
    maintainer_email="maintainers@flatplank.example",
    license="Apache-2.0",
    packages=find_namespace_packages(include=[f"{NAME}*"]),
    package_data={"": ["*.yaml", "*.json", "*.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *shared("config", "launch"),
    ],
    install_requires=[
        "numpy",
        "pyyaml",
        "mcap",
        "rosbags",
        "zstandard",
        "control",
        "matplotlib",
    ],
    extras_require={"test": ["pytest"]},
    entry_points={"console_scripts": NODES, "flatplank.verbs": VERBS},
    python_requires=">=3.10",
    zip_safe=True,
)
