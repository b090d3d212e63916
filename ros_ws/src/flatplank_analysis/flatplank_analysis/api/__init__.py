# SPDX-License-Identifier: Apache-2.0
"""For notebooks and scripts: what the verbs do, as Python; the names are those of the package."""
