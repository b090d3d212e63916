# SPDX-License-Identifier: Apache-2.0
"""Tire models of thesis chapter 7, one file each, with the interface of `models.base`."""
