"""The command line of a node with one of its topics under another name."""

from __future__ import annotations

from collections.abc import Iterator

from launcher.base.model.record import replace
from launcher.base.model.ros_arguments import REMAP, full_node_name, ros_options
from launcher.base.model.spec import ProcessSpec

_ARGUMENTS = "--ros-args"


def hidden_name(topic: str) -> str:
    """The name under which the process publishes; hidden, since a part begins with `_`."""
    return f"{topic}/_injected"


def refusal(spec: ProcessSpec) -> str:
    """Why its topics cannot be renamed; empty if they can."""
    if spec.members:
        return "it is the process of several nodes"
    if spec.shell:
        return "it is a command of a shell"
    if spec.ros is None and _ARGUMENTS not in spec.argv:
        return "it is not started as a ROS node"
    return ""


def renamed(spec: ProcessSpec, topic: str) -> ProcessSpec:
    """The process with `topic`, as others see it, under its hidden name.

    rcl takes the first rule that fits the name in the program, and does not apply rules to the
    result, so rules that lead to the topic get one in front of them; a rule about the topic itself
    stays where it leads elsewhere.
    """
    hidden, argv = hidden_name(topic), spec.argv
    rules = [f"{source}:={hidden}" for source, target in _rules(spec) if target == topic]
    sources = [_absolute(spec, source) for source, _ in _rules(spec)]
    if topic not in sources:
        rules.append(f"{topic}:={hidden}")
    words = [_ARGUMENTS, *(word for rule in rules for word in ("-r", rule))]
    place = argv.index(_ARGUMENTS) if _ARGUMENTS in argv else len(argv)
    return replace(spec, argv=(*argv[:place], *words, *argv[place:]))


def _rules(spec: ProcessSpec) -> Iterator[tuple[str, str]]:
    """(what a rule is about, the full name to which it leads) of each rule about names."""
    for option, value in ros_options(spec.argv):
        source, _, target = value.partition(":=")
        if option == REMAP and not source.rpartition(":")[2].startswith("__"):
            yield source, _absolute(spec, target)


def _absolute(spec: ProcessSpec, name: str) -> str:
    """The full name of a topic in a rule."""
    name = name.rpartition(":")[2]  # behind the name of a node
    if name.startswith("/"):
        return name
    node = full_node_name(spec.argv) or "/"
    if name.startswith("~"):
        return f"{node}/{name[1:].lstrip('/')}"
    namespace = (spec.ros and spec.ros.namespace) or node.rpartition("/")[0]
    return f"{namespace.rstrip('/')}/{name}"
