# SPDX-License-Identifier: Apache-2.0
"""Where the project's checkout is: `test` and `doctor` look at files beside the packages."""

from __future__ import annotations

import os
from pathlib import Path


def project_root() -> Path:
    """The checkout: as `./flatplank` says, else the one around the working directory."""
    if given := os.environ.get("FLATPLANK_ROOT"):
        return Path(given)
    here = Path.cwd()
    for folder in (here, *here.parents):
        if (folder / "flatplank").is_file() and (folder / "ros_ws").is_dir():
            return folder
    raise FileNotFoundError(
        f"{here} is not in a checkout of the project: change into it, or use its ./flatplank"
    )
