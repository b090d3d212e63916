# SPDX-License-Identifier: Apache-2.0
"""What the software is tested and measured with. Not installed; nothing installed imports it."""
