"""Writes the packages of a large launch: five levels of includes, XML and Python, and parameters.

A module has 18 processes and ten components: its top file passes 25 paths and four topics to the
next level, which has three parts, each in a namespace; each process has a launch file with seven
arguments, of which every sixth is in Python, and two parameter files, one of them with `$(...)`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

PARTS, NODES, COMPONENTS = 3, 6, (4, 3, 3)  # of a module, and of a part
PER_MODULE = PARTS * NODES
_PATHS = 8  # of parameter files, passed to each part
_TOP = "large_top"
_VALUES = ("{i}.5", "true", "'text {i}'", "[{i}.0, 1.0, 2.0]", "{i}", "$(var vehicle)_{i}")

_XML_NODE = """<launch>
  {arguments}
  <node pkg="{package}" exec="{program}" name="$(var node_name)" args="--log-level $(var level)">
    <param from="$(var path)" allow_substs="true"/>
    <param from="$(find-pkg-share large_top)/config/common.yaml"/>
    <param name="use_gpu" value="$(var use_gpu)"/>
    <remap from="~/a" to="$(var input_a)"/>
    <remap from="~/b" to="$(var input_b)"/>
    <remap from="~/out" to="$(var output)"/>
  </node>
</launch>
"""
_PYTHON_NODE = """from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction
from launch.substitutions import LaunchConfiguration as Value, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    common = PathJoinSubstitution([FindPackageShare("large_top"), "config", "common.yaml"])
    node = Node(
        package="{package}", executable="{program}", name=Value("node_name"),
        parameters=[Value("path"), common, {{"use_gpu": Value("use_gpu"), "rate": 10.0}}],
        remappings=[("~/a", Value("input_a")), ("~/b", Value("input_b")),
                    ("~/out", Value("output"))],
        arguments=["--log-level", Value("level")])
    defaults = {defaults!r}
    arguments = [DeclareLaunchArgument(name, default_value=text) for name, text in defaults.items()]
    return LaunchDescription([*arguments, GroupAction([node])])
"""


def write(prefix: Path, count: int, programs: Sequence[Path] = (), *, components: bool) -> Path:
    """The top launch file, with `count` processes and perhaps components.

    `programs` are what the processes run, each with the argument 1000; without them, `sleep`.
    """
    top = _package(prefix, _TOP)
    _parameters(top / "config/common.yaml", 15, substitutions=False)
    _program(prefix / "lib/rclcpp_components/component_container", None)
    _package(prefix, "rclcpp_components")
    names = range(count // PER_MODULE + bool(count % PER_MODULE))
    lines = [_argument("vehicle", default="sample")]
    lines += [_argument(f"global_{number}", default=f"value_{number}") for number in range(40)]
    lines += ['<set_parameter name="use_sim_time" value="false"/>']
    for module in names:
        lines += [
            _argument(f"launch_{module}", default="true"),
            f'<group if="$(var launch_{module})">',
            f'<include file="$(find-pkg-share {_TOP})/launch/component_{module}.launch.xml"/>',
            "</group>",
        ]
        mine = range(module * PER_MODULE, min(count, (module + 1) * PER_MODULE))
        _module(prefix, top, module, [programs[n] if programs else None for n in mine], components)
    return _xml(top / "launch/large.launch.xml", lines)


def _module(
    prefix: Path, top: Path, module: int, programs: Sequence[Path | None], components: bool
) -> None:
    package = f"large_module_{module}"
    share = _package(prefix, package)
    names = [f"path_{module}_{number}" for number in range(PARTS * _PATHS)]
    topics = [f"topic_{number}" for number in range(4)]
    lines = [f'<let name="config_{module}" value="$(find-pkg-share {package})/config"/>']
    if components:
        lines += [
            '<node_container pkg="rclcpp_components" exec="component_container" '
            f'name="container_{module}" namespace="/"/>'
        ]
    lines += [f'<include file="$(find-pkg-share {package})/launch/module.launch.xml">']
    lines += [_argument("container", f"container_{module}")]
    lines += [_argument(name, f"$(var config_{module})/{n}.yaml") for n, name in enumerate(names)]
    lines += [_argument(name, f"/{module}/{name}") for name in topics]
    _xml(top / f"launch/component_{module}.launch.xml", [*lines, "</include>"])
    lines = [_argument(name) for name in ("container", *names, *topics)]
    lines += ["<group>", f'<push-ros-namespace namespace="module_{module}"/>']
    for part in range(PARTS):
        passed = {name: f"$(var {name})" for name in ("container", *topics)}
        passed |= {f"path_{n}": f"$(var {names[part * _PATHS + n]})" for n in range(_PATHS)}
        lines += [
            _argument(f"mode_{part}", default="fast"),
            f'<group><push-ros-namespace namespace="part_{part}"/>',
            f'<include file="$(find-pkg-share {package})/launch/part_{part}.launch.xml" '
            f"if=\"$(eval &quot;'$(var mode_{part})' == 'fast'&quot;)\">",
            *(_argument(name, value) for name, value in passed.items()),
            "</include></group>",
        ]
        few = programs[part * NODES : (part + 1) * NODES]
        _part(prefix, package, part, few, COMPONENTS[part] if components else 0)
    _xml(share / "launch/module.launch.xml", [*lines, "</group>"])


def _part(
    prefix: Path, package: str, part: int, programs: Sequence[Path | None], components: int
) -> None:
    share = prefix / "share" / package
    names = ["container", *(f"path_{n}" for n in range(_PATHS)), *(f"topic_{n}" for n in range(4))]
    lines = [_argument(name) for name in names]
    if components:
        lines += ['<load_composable_node target="/$(var container)">']
    for number in range(components):
        file = f"component_{part}_{number}.yaml"
        _parameters(share / "config" / file, 15)
        lines += [
            f'<composable_node pkg="{package}" plugin="P{number}" name="part_{part}_{number}">',
            '<remap from="in" to="$(var topic_0)"/>',
            f'<param from="$(find-pkg-share {package})/config/{file}" allow_substs="true"/>',
            "</composable_node>",
        ]
    lines += ["</load_composable_node>"] if components else []
    for number, program in enumerate(programs, part * NODES):
        lines += _node(prefix, package, number, program)
    _xml(share / f"launch/part_{part}.launch.xml", lines)


def _node(prefix: Path, package: str, number: int, program: Path | None) -> list[str]:
    """The group that includes the launch file of a process."""
    share, name = prefix / "share" / package, f"node_{number}"
    is_python = number % NODES == NODES - 1
    file = f"{name}.launch.{'py' if is_python else 'xml'}"
    values = {"node_name": name, "path": "", "input_a": "a", "input_b": "b", "output": "out"}
    values |= {"use_gpu": "false", "level": "info"}
    arguments = "\n  ".join(_argument(one, default=text) for one, text in values.items())
    text = (_PYTHON_NODE if is_python else _XML_NODE).format(
        package=package, program=name, arguments=arguments, defaults=values
    )
    (share / "launch" / file).write_text(text)
    _parameters(share / f"config/{name}.yaml", 20)
    _program(prefix / "lib" / package / name, program)
    given = {"node_name": name, "path": f"$(find-pkg-share {package})/config/{name}.yaml"}
    given |= {"input_a": "$(var topic_1)", "input_b": "$(var topic_2)", "output": f"out_{number}"}
    passed = "".join(_argument(*pair) for pair in given.items())
    include = f'<include file="$(find-pkg-share {package})/launch/{file}">{passed}</include>'
    return ["<group>", f'<let name="here" value="{name}"/>', include, "</group>"]


def _package(prefix: Path, name: str) -> Path:
    index = prefix / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True, exist_ok=True)
    (index / name).touch()
    share = prefix / "share" / name
    for folder in ("launch", "config"):
        (share / folder).mkdir(parents=True, exist_ok=True)
    return share


def _program(path: Path, program: Path | None) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\nexec {program or '/bin/sleep'} 1000\n")
    path.chmod(0o755)


def _parameters(path: Path, count: int, *, substitutions: bool = True) -> None:
    kinds = _VALUES if substitutions else _VALUES[:-1]
    lines = [f"    p{i}: {kinds[i % len(kinds)].format(i=i)}" for i in range(count)]
    lines += ["    gains:", *(f"      g{i}: {i}.25" for i in range(6))]
    path.write_text("\n".join(["/**:", "  ros__parameters:", *lines, ""]))


def _argument(name: str, value: str | None = None, *, default: str | None = None) -> str:
    text = f'value="{value}"' if value is not None else ""
    text = text or (f'default="{default}"' if default is not None else "")
    return f'<arg name="{name}" {text}/>'


def _xml(path: Path, lines: Sequence[str]) -> Path:
    path.write_text("\n".join(["<launch>", *lines, "</launch>"]))
    return path
