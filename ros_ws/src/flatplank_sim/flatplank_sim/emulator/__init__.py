# SPDX-License-Identifier: Apache-2.0
"""An EtherCAT segment in software: frames in, frames out; devices from a bus file, a plant behind
them."""
