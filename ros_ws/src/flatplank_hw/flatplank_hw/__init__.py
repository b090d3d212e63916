# SPDX-License-Identifier: Apache-2.0
"""Bus, measurement hub, encoders and drives of the flat plank."""
