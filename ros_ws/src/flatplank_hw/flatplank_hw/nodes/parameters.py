# SPDX-License-Identifier: Apache-2.0
"""Declares the parameter sets of the cores as ROS parameters and checks them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from flatplank_data import params
from flatplank_data.names import nearest_hint
from flatplank_hw.share import packaged_parameters


def _descriptor(info: params.ParamInfo) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(description=info.description, read_only=info.read_only)
    if info.bounds and isinstance(info.default, float):
        low, high = info.bounds
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    elif info.bounds and isinstance(info.default, int) and not isinstance(info.default, bool):
        low, high = (int(b) for b in info.bounds)
        descriptor.integer_range = [IntegerRange(from_value=low, to_value=high)]
    return descriptor


def declare_parameter_set(node: Node, cls: type) -> None:
    """Declare every parameter of a set; initial values are not checked here. The defaults are
    those of the file that the package has for a node of this name, as in a launched bench."""
    packaged = packaged_parameters(type(node).__module__.partition(".")[0], node.get_name())
    for info in params.parameter_infos(cls):
        default = packaged.get(info.name, info.default)
        default = list(default) if isinstance(default, tuple) else default
        node.declare_parameter(info.name, default, _descriptor(info))


def check_parameter_names(node: Node) -> None:
    """Raise ValueError for an unknown key in a parameter file, with the nearest known one."""
    known = set(node._parameters)  # rclpy has no public list of these without a service call
    for key in node._parameter_overrides:
        if key not in known and not key.startswith("qos_overrides."):
            raise ValueError(
                f"{node.get_name()}: unknown parameter '{key}'{nearest_hint(key, known)}"
            )


def read_parameter_set(node: Node, cls: type, changes: Mapping[str, Any] | None = None) -> Any:
    """The present parameter set of the node with `changes` applied, checked as a whole."""
    names = [info.name for info in params.parameter_infos(cls)]
    values = {name: node.get_parameter(name).value for name in names}
    values |= {k: v for k, v in (changes or {}).items() if k in values}
    values = {
        k: tuple(v) if isinstance(v, (list,)) or hasattr(v, "typecode") else v
        for k, v in values.items()
    }
    return params.from_mapping(cls, values, node.get_name())
