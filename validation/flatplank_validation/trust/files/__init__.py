# SPDX-License-Identifier: Apache-2.0
"""Files that readers get damaged, and the independent readers that judge what comes out."""
