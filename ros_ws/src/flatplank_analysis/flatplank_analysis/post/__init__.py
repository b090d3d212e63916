# SPDX-License-Identifier: Apache-2.0
"""Post-processing of section 6.2, each step a function that can be left out."""
