# SPDX-License-Identifier: Apache-2.0
"""The programs of this package that `ros2 run` starts, as in `flatplank_hw.start`."""

from __future__ import annotations

from flatplank_hw.start import starter

__getattr__ = starter("flatplank_sim")
