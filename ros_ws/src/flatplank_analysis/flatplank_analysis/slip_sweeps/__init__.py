# SPDX-License-Identifier: Apache-2.0
"""Sweeps of slip on other test benches: what was measured, and where a tire file fails."""
