# SPDX-License-Identifier: Apache-2.0
"""Reports: `build(campaign, out)` writes a page, its figures and tables, and a JSON file."""

from flatplank_analysis.report.build import build, write

__all__ = ["build", "write"]
