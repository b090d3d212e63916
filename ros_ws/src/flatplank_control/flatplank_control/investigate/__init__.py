# SPDX-License-Identifier: Apache-2.0
"""An investigation on a bench: plans, the campaign that makes them, the journal on the disk."""
