# SPDX-License-Identifier: Apache-2.0
"""Margins of the free-rolling loop: continuous as in the thesis, discrete with the real delay."""

from __future__ import annotations

from flatplank_control.free_rolling import FreeRollingParameters
from flatplank_validation.free_rolling import linear


def main() -> None:
    for name, loop in {
        "thesis, continuous (wanted: 39.92 deg, 5.22 Hz, 32.73 s)": linear.thesis_loop(),
        "as run: 250 Hz, two cycles and hold (wanted: 30 deg)": linear.real_loop(
            FreeRollingParameters()
        ),
    }.items():
        f = linear.figures(loop)
        print(f"{name}:")
        if name.startswith("thesis"):
            print(f"  settling to 0.5 %: {linear.settling_time(loop):.2f} s")
        print("  " + ", ".join(f"{k} {v:.4g}" for k, v in f._asdict().items()))


if __name__ == "__main__":
    main()
