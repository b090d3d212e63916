# SPDX-License-Identifier: Apache-2.0
"""The operator's page in the browser: bench, runs, discovery."""

from __future__ import annotations

import argparse
import secrets
import socket
import sys
from pathlib import Path

from flatplank_analysis.cli import main as command
from flatplank_data.arguments import Parser, add_namespace
from flatplank_hw.process import end_with_parent
from flatplank_panel.access import address


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank panel", description=__doc__)
    p.add_argument("--host", default="127.0.0.1", help="address to listen at")
    p.add_argument("--port", type=int, default=8080)
    p.add_argument(
        "--data", type=Path, default=Path("data"), help="folder of the bags and campaigns"
    )
    p.add_argument("--token", default="", help="of the page; default: a new one, printed")
    p.add_argument(
        "--log", type=Path, help="file for what the nodes print; default: DATA/bench.log"
    )
    add_namespace(p)
    p.add_argument("--parameters", type=Path, help="ROS parameter file, laid over the bench's own")
    return p


def check_port_free(host: str, port: int) -> None:
    """Raise ValueError when the port is taken."""
    family, kind, protocol, _, place = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    with socket.socket(family, kind, protocol) as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind(place)
        except OSError as error:
            raise ValueError(
                f"{host}:{port}: {error.strerror}; end the program that has it, or give another "
                "--port"
            ) from None


def main(argv: list[str]) -> int:
    """Serve until Ctrl-C."""
    o = parser().parse_args(argv)
    end_with_parent()
    check_port_free(o.host, o.port)
    token = o.token or secrets.token_urlsafe(24)
    try:
        o.data.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        print(f"flatplank panel: {o.data}: {error.strerror}; name another folder", file=sys.stderr)
        return 1
    from flatplank_panel.app import serve
    from flatplank_panel.bench_state import BenchState
    from flatplank_panel.host import Host, read_parameters
    from flatplank_panel.nodes.panel import PanelNode
    from flatplank_panel.operator import Operator
    from flatplank_panel.service import AnalysisService

    try:
        parameters = read_parameters(o.parameters) if o.parameters else {}
    except ValueError as error:
        print(f"flatplank panel: {error}", file=sys.stderr)
        return 1
    with PanelNode(BenchState(), namespace=o.namespace) as link:
        data, log = o.data.resolve(), o.log or o.data / "bench.log"
        host = Host(data, log, parameters, o.namespace)
        where = address(o.host, o.port, token)
        print(f"panel: {where}\ndata: {data}; Ctrl-C ends it", flush=True)
        try:
            serve(Operator(link, host, data), AnalysisService(data, log), o.host, o.port, token)
        finally:
            host.stop()
    return 0


def program() -> int:
    """Entry point of `ros2 run flatplank_panel panel`: runs the verb of `flatplank`."""
    return command.main(["panel", *sys.argv[1:]])
