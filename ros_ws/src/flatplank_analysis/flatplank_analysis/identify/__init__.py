# SPDX-License-Identifier: Apache-2.0
"""Identification: parameters from measurements, with what the data can and cannot say."""
