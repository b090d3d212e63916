# SPDX-License-Identifier: Apache-2.0
"""Identification: parameters from measurements, and what the data do not determine."""
