# SPDX-License-Identifier: Apache-2.0
"""`python -m flatplank_hw.ethercat.esi FILE`: list devices, or put one into a bus file."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from flatplank_data.yaml_text import parse_yaml
from flatplank_hw.ethercat.esi import find_device, merge_device, read_esi
from flatplank_hw.ethercat.reader import parse_bus, read_bus_file
from flatplank_hw.ethercat.writer import write_bus


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """Command line."""
    parser = argparse.ArgumentParser(prog="esi", description="ESI and ENI files into the bus file")
    parser.add_argument("file", help="ESI or ENI file (XML)")
    parser.add_argument("--type", default="", help="type name; in an ENI file the slave's name")
    parser.add_argument("--product", type=lambda t: int(t, 0), help="product code")
    parser.add_argument("--revision", type=lambda t: int(t, 0), help="revision; default: newest")
    parser.add_argument("--bus", help="bus file to start from")
    parser.add_argument("--slave", help="slave of the bus file that this device is")
    parser.add_argument("--rated-torque-nm", type=float, default=0.0)
    parser.add_argument("--out", help="where to write the new bus file; default: to the screen")
    return parser.parse_args(arguments)


def run(options: argparse.Namespace) -> str:
    """Return the list of devices, or the text of the new bus file."""
    devices = read_esi(options.file)
    if not options.bus:
        return "\n".join(
            f"{d.type_name}: product 0x{d.product:08X}, revision 0x{d.revision:08X}, {d.name}"
            for d in devices
        )
    device = find_device(devices, options.type, options.product, options.revision)
    bus = merge_device(
        read_bus_file(options.bus), options.slave or "", device, options.rated_torque_nm
    )
    return write_bus(bus)


def main(arguments: list[str] | None = None) -> int:
    """Run the command; on failure print one line and return exit code 2."""
    options = parse(arguments)
    try:
        text = run(options)
        if options.bus:
            _check(text)
    except ValueError as error:
        print(f"esi: {error}", file=sys.stderr)
        return 2
    if options.out:
        Path(options.out).write_text(text, encoding="utf-8")
    else:
        print(text)
    return 0


def _check(text: str) -> None:
    """Check that the written bus file can be read."""

    parse_bus(parse_yaml(text), "new bus file")


if __name__ == "__main__":
    raise SystemExit(main())
