"""The table of verbs: the name of each, its task, its module and its line of help.

`main(words)` of the module runs the verb and returns the exit code; `COMMAND` has its options.
"""

# What `--help` is arranged by: each task with the title of its verbs.
TASKS = {
    "Run": "Run",
    "Control": "Control a running launch, from any shell",
    "Look": "Look at a running launch, and at ROS",
    "Record": "Record",
    "Build": "Build",
    "Test": "Test",
    "Other machines": "Other machines",
    "Tools": "Tools",
}
RUN, CONTROL, LOOK, RECORD, BUILD, TEST, MACHINES, TOOLS = TASKS
INTERNAL = "Internals"  # verbs that only `help --all` lists

_TABLE = (
    ("launch", RUN, "launcher.launch.verbs.launch", "run a launch file; `launch` may be left out"),
    ("plan", RUN, "launcher.launch.verbs.plan", "show what a launch file would start, and why"),
    ("args", RUN, "launcher.launch.verbs.args", "list the arguments of a launch file"),
    ("run", RUN, "launcher.launch.verbs.run", "run one executable of a package in this terminal"),
    ("demo", RUN, "launcher.launch.verbs.demo", "run the robot fleet that comes with the launcher"),
    (
        "build",
        BUILD,
        "launcher.workspace.verbs.build",
        "build the packages of a workspace, message types included",
    ),
    (
        "wheel",
        BUILD,
        "launcher.workspace.verbs.wheel",
        "make wheels of built packages, to install them without a compiler",
    ),
    ("topic", LOOK, "launcher.ros.verbs.topic", "list, inspect, print, measure and publish topics"),
    ("node", LOOK, "launcher.ros.verbs.node", "list and inspect nodes"),
    ("param", LOOK, "launcher.ros.verbs.param", "list, get and set parameters of nodes"),
    (
        "service",
        LOOK,
        "launcher.ros.verbs.service",
        "list and call services, and print their events",
    ),
    ("action", LOOK, "launcher.ros.verbs.action", "list actions, and send goals"),
    (
        "lifecycle",
        LOOK,
        "launcher.ros.verbs.lifecycle",
        "show and change the states of lifecycle nodes",
    ),
    (
        "interface",
        LOOK,
        "launcher.ros.verbs.interface",
        "show the installed types of messages, services and actions",
    ),
    ("tf", LOOK, "launcher.ros.verbs.tf", "show transforms and the tree of frames, without tf2"),
    ("bag", RECORD, "launcher.bag.verbs", "record topics, play and compare recordings"),
    (
        "pkg",
        BUILD,
        "launcher.workspace.verbs.pkg",
        "make packages of nodes and of interfaces, and look at installed ones",
    ),
    (
        "env",
        BUILD,
        "launcher.workspace.verbs.env",
        "print the environment of a workspace, for shells and editors",
    ),
    (
        "test",
        TEST,
        "launcher.workspace.verbs.test",
        "run the tests of packages; to test a launch file: smoke",
    ),
    ("doctor", TOOLS, "launcher.doctor.verb", "find what is wrong on this machine, and repair it"),
    (
        "hosts",
        MACHINES,
        "launcher.hosts.verbs",
        "try other hosts, and bring the launcher and packages to them",
    ),
    (
        "attach",
        MACHINES,
        "launcher.hosts.verbs.attach",
        "return to a run whose processes were left on other hosts",
    ),
    ("analyze", TOOLS, "launcher.launch.analyze", "show where the time of a start-up went"),
    ("smoke", TEST, "launcher.smoke.verb", "test a launch file against expectations"),
    ("launch-test", TEST, "launcher.smoke.launch_tests.verb", "run a test of launch_testing"),
    (
        "export",
        MACHINES,
        "launcher.export.verbs.export",
        "write a launch file as units of systemd, Kubernetes, Compose or Podman",
    ),
    ("graph", LOOK, "launcher.ros.verbs.graph", "show the ROS graph as a tree, a drawing or data"),
    (
        "web",
        LOOK,
        "launcher.web.verb",
        "serve a page in the browser that shows and controls a running launch",
    ),
    (
        "incident",
        LOOK,
        "launcher.faults.incident.verb",
        "write one HTML file about an incident of a run: cause, timeline, graph, log, bag",
    ),
    (
        "faults",
        LOOK,
        "launcher.faults.verb",
        "list what is wrong in a watched run, since when, and why",
    ),
    (
        "foxglove",
        LOOK,
        "launcher.ros.foxglove.verb",
        "show the ROS graph to Foxglove and to Lichtblick",
    ),
    (
        "mcp",
        CONTROL,
        "launcher.web.remote.verb",
        "serve runs to other programs by the Model Context Protocol (MCP)",
    ),
    (
        "wait",
        CONTROL,
        "launcher.ros.verbs.wait",
        "wait for processes of a run, and for topics, services and nodes",
    ),
    (
        "multicast",
        INTERNAL,
        "launcher.ros.verbs.multicast",
        "send or receive one packet by multicast, to try a network",
    ),
    (
        "daemon",
        INTERNAL,
        "launcher.ros.verbs.daemon",
        "say that no daemon is needed, for scripts that use ros2",
    ),
    (
        "agent",
        INTERNAL,
        "launcher.hosts.verbs.agent",
        "run processes for a launcher on another machine, which starts this by ssh",
    ),
    (
        "completion",
        INTERNAL,
        "launcher.cli.completion",
        "print the script that completes words in bash, zsh or fish",
    ),
)

# Each verb with its line of help.
VERBS = {name: help for name, _, _, help in _TABLE}
_MODULES = {name: module for name, _, module, _ in _TABLE}

# Verbs about a ROS graph.
_OF_ROS = ("launcher.ros.", "launcher.bag.")
ROS_VERBS = tuple(name for name, module in _MODULES.items() if module.startswith(_OF_ROS))

# Modules of wings that serve the core: `enable(request, options)` and `disable` of a launch, and
# `verb_first(words)`, which puts options of ROS verbs behind the verb.
ENABLE = "launcher.export.verbs.enable"
ROS_FRONT = "launcher.ros.front"
# The transforms of a bag, for `tf`: `ros` does not import `bag`.
BAG_TRANSFORMS = "launcher.bag.transforms:samples"

# Other names of verbs.
ALIASES = {"wtf": "doctor"}


def module_of(verb: str) -> str:
    """The full name of a verb's module."""
    return "launcher.control.verb" if verb == "control" else _MODULES[verb]


# Verbs about a running launch, each with its task. Their table is in launcher.control.verbs, which
# is not imported on the way to the first process of a run; their module is launcher.control.verb.
CONTROL_VERBS = {
    "ps": LOOK,
    "top": LOOK,
    "kill": CONTROL,
    "stop": CONTROL,
    "start": CONTROL,
    "restart": CONTROL,
    "pause": CONTROL,
    "resume": CONTROL,
    "mute": CONTROL,
    "unmute": CONTROL,
    "solo": CONTROL,
    "level": CONTROL,
    "grep": CONTROL,
    "show": CONTROL,
    "format": CONTROL,
    "logs": LOOK,
    "info": LOOK,
    "send": CONTROL,
    "events": LOOK,
    "detach": MACHINES,
    "reload": CONTROL,
    "watch": CONTROL,
    "stack": LOOK,
    "debug": CONTROL,
    "loglevel": CONTROL,
    "inject": CONTROL,
    "snapshot": RECORD,
    "quit": CONTROL,
    "runs": LOOK,
}
# The task of each verb, a key of TASKS, or INTERNAL.
TASK_OF = {**{name: task for name, task, _, _ in _TABLE}, **CONTROL_VERBS}

# Verbs of the console that a shell does not have, with an alternative.
CONSOLE_VERBS = {"pick": "PROGRAM ps lists the processes; F2 opens the list in the console"}

# Verbs of ros2cli that do not exist here, with an alternative.
ABSENT_VERBS = {
    "component": "component containers are C++ programs of a ROS installation, into which a launch "
    "file loads components; Python nodes share a process with --compose",
    "control": None,
    "extension_points": None,
    "extensions": None,
    "plugin": None,
    "security": "keystores are made by sros2 of a ROS installation; nodes find them by "
    "ROS_SECURITY_ENABLE and ROS_SECURITY_KEYSTORE",
    "trace": None,
}
