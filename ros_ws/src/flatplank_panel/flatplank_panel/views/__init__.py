# SPDX-License-Identifier: Apache-2.0
"""Views of the page, one module per part."""
