# SPDX-License-Identifier: Apache-2.0
"""Device descriptions of makers (ESI, ENI), into a bus file."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from flatplank_data.arguments import Parser
from flatplank_data.files import write_atomic
from flatplank_data.yaml_text import parse_yaml
from flatplank_hw.ethercat.esi import EsiDevice, EsiError, find_device, merge_device, read_esi
from flatplank_hw.ethercat.esi.numbers import parse_number
from flatplank_hw.ethercat.reader import parse_bus, read_bus_file
from flatplank_hw.ethercat.writer import write_bus


def code(text: str) -> int:
    """A product code or revision of the command line, as in an ESI file."""
    try:
        return parse_number(text, "it")
    except EsiError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def parser() -> argparse.ArgumentParser:
    """Command line."""
    p = Parser(prog="flatplank esi", description=__doc__)
    p.add_argument("file", help="ESI or ENI file (XML)")
    p.add_argument("--type", default="", help="type name; in an ENI file the slave's name")
    p.add_argument("--product", type=code, help="product code, as in 4097 or 0x1001")
    p.add_argument("--revision", type=code, help="revision; default: the newest")
    p.add_argument("--bus", help="bus file to start from; without it the devices are listed")
    p.add_argument("--slave", help="slave of the bus file that this device is")
    p.add_argument("--rated-torque-nm", type=float, default=0.0, help="of the motor [N m]")
    p.add_argument("--out", help="where to write the new bus file; default: to the screen")
    return p


def run(options: argparse.Namespace) -> tuple[str, EsiDevice | None]:
    """The list of devices, or the text of the new bus file and its device."""
    devices = read_esi(options.file)
    if not options.bus:
        lines = (
            f"{d.type_name}: product 0x{d.product:08X}, revision 0x{d.revision:08X}, {d.name}"
            for d in devices
        )
        return "\n".join(lines), None
    device = find_device(devices, options.type, options.product, options.revision)
    bus = merge_device(
        read_bus_file(options.bus), options.slave or "", device, options.rated_torque_nm
    )
    text = write_bus(bus)
    parse_bus(parse_yaml(text), "new bus file")
    return text, device


def main(argv: list[str] | None = None) -> int:
    """Exit code 0: done; 2: refused, with one line."""
    options = parser().parse_args(argv)
    try:
        text, device = run(options)
        if device is not None and options.out:
            write_atomic(Path(options.out), text)
    except (ValueError, OSError) as error:
        text = " ".join(str(error).split())
        where = "" if options.file in text else f"{options.file}: "
        print(f"flatplank esi: {where}{text}", file=sys.stderr)
        return 2
    for note in device.notes if device else ():
        print(f"flatplank esi: note: {note}", file=sys.stderr)
    if not (device and options.out):
        print(text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
