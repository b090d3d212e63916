# SPDX-License-Identifier: Apache-2.0
"""The analysis behind the pages Runs and Discover: in processes of its own, so that no fit ever
delays a heartbeat, and that a search can be cancelled by ending its process."""
