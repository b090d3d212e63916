# SPDX-License-Identifier: Apache-2.0
"""Check of facts that must not change from one version to the next."""
