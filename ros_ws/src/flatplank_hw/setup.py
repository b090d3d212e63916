# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from setuptools import find_namespace_packages, setup

NAME = "flatplank_hw"
# One line per program: `ros2 run flatplank_hw NAME`.
NODES = [
    "measurement_hub = flatplank_hw.start:measurement_hub",
    "encoders = flatplank_hw.start:encoders",
    "wheel_drive = flatplank_hw.start:wheel_drive",
    "ethercat_bus = flatplank_hw.start:ethercat_bus",
]


def shared(*folders):
    """Files of these folders, to be installed under share/<package> at the same relative path."""
    files = (path for folder in folders for path in Path(folder).rglob("*") if path.is_file())
    return [(f"share/{NAME}/{path.parent}", [str(path)]) for path in sorted(files)]


setup(
    name=NAME,
    version="0.1.0",
    description="Bus, measurement hub, encoders and drives of the flat plank bench.",
    maintainer="Flat Plank maintainers",
    maintainer_email="maintainers@flatplank.example",
    license="Apache-2.0",
    packages=find_namespace_packages(include=[f"{NAME}*"]),
    package_data={"": ["*.yaml", "*.json"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *shared("config", "launch"),
    ],
    install_requires=["numpy", "pyyaml", "scipy"],
    extras_require={"ethercat": ["pysoem"], "test": ["pytest"]},
    entry_points={"console_scripts": NODES},
    python_requires=">=3.10",
    zip_safe=True,
)
