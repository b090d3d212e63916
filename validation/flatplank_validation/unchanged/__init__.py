# SPDX-License-Identifier: Apache-2.0
"""What stays the same from one version to the next, and how to see it."""
