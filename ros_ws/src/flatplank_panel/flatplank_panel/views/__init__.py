# SPDX-License-Identifier: Apache-2.0
"""What the operator sees, one module per part of the page."""
