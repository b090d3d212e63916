# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from setuptools import find_namespace_packages, setup

NAME = "flatplank_sim"
# One line per program: `ros2 run flatplank_sim NAME`.
NODES = [
    "simulated_plant = flatplank_sim.start:simulated_plant",
    "emulated_bus = flatplank_sim.start:emulated_bus",
    "ethercat_emulator = flatplank_sim.emulator.__main__:main",
]
# One line per verb of the command `flatplank`: a module with `main(argv) -> exit code`; the first
# line of its docstring is the help.
VERBS = [
    "simulate = flatplank_sim.cli.simulate:main",
    "demo = flatplank_sim.cli.demo:main",
    "reveal = flatplank_sim.cli.reveal:main",
]
# How control and panel find the simulated bench (flatplank_control/bench/simulator.py).
SIMULATOR = ["installed = flatplank_sim.simulator"]


def shared(*folders):
    """Files of these folders, to be installed under share/<package> at the same relative path."""
    files = (path for folder in folders for path in Path(folder).rglob("*") if path.is_file())
    return [(f"share/{NAME}/{path.parent}", [str(path)]) for path in sorted(files)]


setup(
    name=NAME,
    version="0.1.0",
    description="Simulated plant, EtherCAT emulator and twin of the flat plank bench.",
    maintainer="Flat Plank maintainers",
    maintainer_email="maintainers@flatplank.example",
    license="Apache-2.0",
    packages=find_namespace_packages(include=[f"{NAME}*"]),
    package_data={"": ["*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *shared("config"),
    ],
    install_requires=["numpy", "scipy", "numba"],
    extras_require={"test": ["pytest"]},
    entry_points={
        "console_scripts": NODES,
        "flatplank.verbs": VERBS,
        "flatplank.simulator": SIMULATOR,
    },
    python_requires=">=3.10",
    zip_safe=True,
)
