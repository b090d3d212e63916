# SPDX-License-Identifier: Apache-2.0
"""Slip sweeps of other test benches: measured curves, and where a tire file fails."""
