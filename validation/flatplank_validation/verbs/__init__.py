# SPDX-License-Identifier: Apache-2.0
"""The verbs `bench-*` of a checkout."""
