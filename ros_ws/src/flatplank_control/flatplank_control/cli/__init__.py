# SPDX-License-Identifier: Apache-2.0
"""Verbs of the bench: one module each, registered in setup.cfg."""
