# SPDX-License-Identifier: Apache-2.0
"""Start the whole bench: `ros2 launch flatplank_control bench.launch.py sim:=true`."""

import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from flatplank_control.bench.launching import ARGUMENTS, check_argument_names, setup_of, why_ended
from flatplank_control.bench.processes import arguments_of_files, words_of_nodes
from flatplank_control.bench.setup import LOOP, NodeSpec
from flatplank_hw.process import END_WITH_PARENT
from launch import LaunchContext, LaunchDescription


class BenchEnded(Exception):
    """A node has ended: launch prints why, ends the other nodes, and returns exit code 1."""


def on_exit(name: str) -> Callable[[ProcessExited, LaunchContext], None]:
    """End the bench when any node ends, as `flatplank bench` does."""

    def end(event: ProcessExited, context: LaunchContext) -> None:
        if not context.is_shutdown:
            raise BenchEnded(why_ended(name, event.returncode))

    return end


def make_nodes(context: LaunchContext) -> list[Node]:
    if any(Path(word).name == Path(__file__).name for word in sys.argv):
        check_argument_names(sys.argv)
    setup = setup_of({name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS})
    files = setup.write(Path(tempfile.mkdtemp(prefix="flatplank-")))
    return [
        make_process(name, nodes, files, setup.namespace)
        for name, nodes in setup.processes().items()
    ]


def make_process(
    name: str, nodes: tuple[NodeSpec, ...], files: dict[str, Path], namespace: str
) -> Node:
    common = {
        "namespace": namespace,
        "output": "screen",
        "additional_env": {END_WITH_PARENT: str(os.getpid())},
        "on_exit": on_exit(name),
    }
    if len(nodes) > 1:
        return Node(
            package="flatplank_control",
            executable=LOOP,
            arguments=words_of_nodes(nodes),
            ros_arguments=arguments_of_files(nodes, files),
            **common,
        )
    (node,) = nodes
    return Node(
        package=node.package,
        executable=node.executable,
        name=node.name,
        parameters=[str(files[node.name])],
        **common,
    )


def generate_launch_description() -> LaunchDescription:
    arguments = [
        DeclareLaunchArgument(
            name,
            default_value=argument.default,
            description=argument.text,
            choices=list(argument.choices) or None,
        )
        for name, argument in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=make_nodes)])
