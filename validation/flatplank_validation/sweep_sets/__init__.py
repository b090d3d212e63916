# SPDX-License-Identifier: Apache-2.0
"""Generated sweeps with a hidden cause, by a brush that shares no code with the models."""
