"""A trial as a node: its vehicle from parameters, its names from the namespace and remapping, its domain from ROS_DOMAIN_ID.

Becomes the command `seatrial trial`, which needs no ROS, once ROS has resolved everything.
"""

import json
import os
import shutil
import sys
import tempfile

import rclpy
from rclpy.node import Node


def description(node):
    """The file of a vehicle, from the parameters below `vehicle`."""
    namespace = node.get_namespace().rstrip("/")
    values = {"domain": int(os.environ.get("ROS_DOMAIN_ID") or 0), "namespace": namespace}
    for name, parameter in node.get_parameters_by_prefix("vehicle").items():
        value = parameter.value
        if name.endswith(".topic"):
            value = node.resolve_topic_name(value)
        elif name.endswith(".service"):
            value = node.resolve_service_name(value)
        values[name] = value
    # Names with dots and the values of JSON are TOML, too.
    return "".join(f"{name} = {json.dumps(value)}\n" for name, value in values.items())


def main():
    rclpy.init()
    node = Node("seatrial", automatically_declare_parameters_from_overrides=True)
    command = shutil.which("seatrial")
    if command is None:
        sys.exit("seatrial is not in PATH; install it built with --features ros2")
    with tempfile.NamedTemporaryFile("w", suffix=".toml", delete=False) as file:
        file.write(description(node))
    parameter = node.get_parameter_or
    plan = parameter("plan", None)
    arguments = ["--plan", plan.value] if plan else []
    more = parameter("arguments", None)
    arguments += more.value if more else []
    node.destroy_node()
    rclpy.shutdown()
    # In place of this process, so that a signal of launch ends the trial itself.
    os.execv(command, ["seatrial", "trial", "--vehicle", f"ros2:{file.name}", *arguments])


if __name__ == "__main__":
    main()
