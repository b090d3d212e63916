# SPDX-License-Identifier: Apache-2.0
"""An EtherCAT segment in software: devices from a bus file, and a plant behind them."""
