# SPDX-License-Identifier: Apache-2.0
from setuptools import find_namespace_packages, setup

NAME = "flatplank_data"

setup(
    name=NAME,
    version="0.1.0",
    description="What a flat plank measurement is: tables, run records, files, limits.",
    maintainer="Flat Plank maintainers",
    maintainer_email="maintainers@flatplank.example",
    license="Apache-2.0",
    packages=find_namespace_packages(include=[f"{NAME}*"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    install_requires=["lz4", "numpy", "pyarrow", "pyyaml", "scipy", "zstandard"],
    extras_require={"remote": ["fsspec"], "test": ["pytest"]},
    python_requires=">=3.10",
    zip_safe=True,
)
