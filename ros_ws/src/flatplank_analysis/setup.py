# SPDX-License-Identifier: Apache-2.0
from setuptools import find_namespace_packages, setup

NAME = "flatplank_analysis"
# One line per verb of the command `flatplank`: a module with `main(argv) -> exit code`; the first
# line of its docstring is the help.
VERBS = [
    "table = flatplank_analysis.cli.table:main",
    "fit = flatplank_analysis.cli.fit:main",
    "tire = flatplank_analysis.cli.tire:main",
    "report = flatplank_analysis.cli.report:main",
    "compare = flatplank_analysis.cli.compare:main",
    "diagnose = flatplank_analysis.cli.diagnose:main",
    "add = flatplank_analysis.cli.add:main",
    "remove = flatplank_analysis.cli.remove:main",
    "undo = flatplank_analysis.cli.undo:main",
    "sweeps = flatplank_analysis.cli.sweeps:main",
    "propose = flatplank_analysis.cli.propose:main",
    "confirm = flatplank_analysis.cli.confirm:main",
    "effects = flatplank_analysis.cli.effects:main",
]

setup(
    name=NAME,
    version="0.1.0",
    description="From flat plank bags to tables, tire models, and the effect that a model lacks.",
    maintainer="Flat Plank maintainers",
    maintainer_email="maintainers@flatplank.example",
    license="Apache-2.0",
    packages=find_namespace_packages(include=[f"{NAME}*"]),
    package_data={"": ["*.yaml", "*.json", "*.tir", "*.csv", "*.html", "*.j2", "*.css"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    install_requires=[
        "flatplank_data",
        "jinja2",
        "markupsafe",
        "matplotlib",
        "numba",
        "numpy",
        "pandas",
        "pyyaml",
        "scipy",
    ],
    extras_require={"cluster": ["distributed"], "test": ["pytest"]},
    entry_points={
        "console_scripts": ["flatplank = flatplank_analysis.cli.main:main"],
        "flatplank.verbs": VERBS,
    },
    python_requires=">=3.10",
    zip_safe=True,
)
