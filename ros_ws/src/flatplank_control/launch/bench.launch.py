# SPDX-License-Identifier: Apache-2.0
"""Start the whole bench: `ros2 launch flatplank_control bench.launch.py sim:=true`."""

import tempfile
from pathlib import Path

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.calibration.book import book_for
from launch import LaunchDescription

ARGUMENTS = {
    "sim": ("false", "true: simulated plant instead of the EtherCAT bus"),
    "tire": ("toyo", "simulated tire"),
    "preset": ("", "defects of the simulated machine, for instance thesis2023"),
    "seed": ("1", "of the simulated plant"),
    "pace": ("realtime", "realtime, lockstep or hold (simulated plant)"),
    "rate_hz": ("250", "bus rate [Hz]"),
    "batch": ("1", "bus cycles per message"),
    "interface": ("", "network interface of the bus, in the lab"),
    "bus": ("", "bus file of the EtherCAT bus; empty: ours, with placeholders"),
    "data": ("data", "folder for the bags"),
    "calibration": ("", "book of the calibrations; empty: of data, else the one here"),
    "axes": ("", "driven beside the wheel: plank,vertical,steer,camber"),
}


def make_nodes(context):
    value = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    setup = BenchSetup(
        kind="sim" if value["sim"].lower() == "true" else "lab",
        tire=value["tire"],
        preset=value["preset"],
        seed=int(value["seed"]),
        pace=value["pace"],
        rate_hz=int(value["rate_hz"]),
        batch=int(value["batch"]),
        interface=value["interface"],
        bus_file=value["bus"],
        data=value["data"],
        calibration=value["calibration"] or str(book_for(Path(value["data"])).path),
        axes=tuple(a for a in value["axes"].split(",") if a),
    )
    files = setup.write(Path(tempfile.mkdtemp(prefix="flatplank-")))
    return [
        Node(
            package=node.package,
            executable=node.executable,
            name=node.name,
            parameters=[str(files[node.name])],
            output="screen",
        )
        for node in setup.nodes()
    ]


def generate_launch_description():
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=make_nodes)])
