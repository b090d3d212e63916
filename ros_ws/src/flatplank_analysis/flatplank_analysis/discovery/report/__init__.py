# SPDX-License-Identifier: Apache-2.0
"""The page of a diagnosis: figures as SVG and PNG, everything as JSON, one HTML file."""
