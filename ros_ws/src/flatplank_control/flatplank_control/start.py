# SPDX-License-Identifier: Apache-2.0
"""Entry points of this package for `ros2 run`, as in `flatplank_hw.start`."""

from __future__ import annotations

from flatplank_hw.start import starter

__getattr__ = starter("flatplank_control")
