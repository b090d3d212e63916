# SPDX-License-Identifier: Apache-2.0
"""The bench as a whole: its set-up, its processes, the entry point of the simulator."""
