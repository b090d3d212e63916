# SPDX-License-Identifier: Apache-2.0
"""The analysis for the pages Runs and Discover. It runs in separate processes, so that no fit
delays a heartbeat and a search can be cancelled by ending its process."""
