# SPDX-License-Identifier: Apache-2.0
from setuptools import find_namespace_packages, setup

NAME = "flatplank_panel"
# One line per program: `ros2 run flatplank_panel NAME`.
NODES = ["panel = flatplank_panel.cli.panel:program"]
# One line per verb of the command `flatplank`: a module with `main(argv) -> exit code`; the first
# line of its docstring is the help.
VERBS = ["panel = flatplank_panel.cli.panel:main"]

setup(
    name=NAME,
    version="0.1.0",
    description="The operator's page of the flat plank bench.",
    maintainer="Flat Plank maintainers",
    maintainer_email="maintainers@flatplank.example",
    license="Apache-2.0",
    packages=find_namespace_packages(include=[f"{NAME}*"]),
    package_data={"": ["*.js", "*.css"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    install_requires=["nicegui", "numpy", "pyyaml"],
    extras_require={"test": ["pytest"]},
    entry_points={"console_scripts": NODES, "flatplank.verbs": VERBS},
    python_requires=">=3.10",
    zip_safe=True,
)
