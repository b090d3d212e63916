# SPDX-License-Identifier: Apache-2.0
"""An investigation on a bench: plans, campaigns, and the journal on disk."""
