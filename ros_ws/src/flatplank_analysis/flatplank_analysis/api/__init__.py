# SPDX-License-Identifier: Apache-2.0
"""The verbs as Python functions and classes, for notebooks and scripts."""
