# SPDX-License-Identifier: Apache-2.0
"""Tire models of thesis chapter 7: each one file behind the interface of `models.base`."""
