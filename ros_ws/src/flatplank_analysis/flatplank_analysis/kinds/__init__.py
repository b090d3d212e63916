# SPDX-License-Identifier: Apache-2.0
"""Models of the measurements that are no slip steps: one file per kind."""
