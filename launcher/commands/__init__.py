"""One module per verb: `main(words)` runs it and returns the exit code."""

# Each verb with its line of help; `module_of` says where it is.
VERBS = {
    "launch": "run a launch file; `launch` may be left out",
    "plan": "show what a launch file would start, and why",
    "args": "list the arguments of a launch file",
    "run": "run one executable of a package in this terminal",
    "build": "build the packages of a workspace, message types included",
    "wheel": "make wheels of built packages, to install them without a compiler",
    "topic": "list, inspect, print, measure and publish topics",
    "node": "list and inspect nodes",
    "param": "list, get and set parameters of nodes",
    "service": "list and call services, and print their events",
    "action": "list actions, and send goals",
    "lifecycle": "show and change the states of lifecycle nodes",
    "interface": "show the installed types of messages, services and actions",
    "bag": "record topics, play and compare recordings",
    "pkg": "make packages of nodes and of interfaces, and look at installed ones",
    "env": "print the environment of a workspace, for shells and editors",
    "test": "run the tests of packages; to test a launch file: smoke",
    "doctor": "find what is wrong on this machine, and repair it",
    "hosts": "try other hosts, and bring the launcher and packages to them",
    "attach": "return to a run whose processes were left on other hosts",
    "analyze": "show where the time of a start-up went",
    "smoke": "test a launch file against expectations",
    "export": "write a launch file as units of systemd, Kubernetes, Compose or Podman",
    "graph": "show the ROS graph as a tree, a drawing or data",
    "web": "serve a page in the browser that shows and controls a running launch",
    "foxglove": "show the ROS graph to Foxglove and to Lichtblick",
    "multicast": "send or receive one packet by multicast, to try a network",
    "daemon": "say that no daemon is needed, for scripts that use ros2",
    "agent": "run processes for a launcher on another machine, which starts this by ssh",
    "completion": "print the script that completes words in bash, zsh or fish",
}

# Verbs about a ROS graph, whose modules are in `launcher.commands.ros`.
ROS_VERBS = (
    "topic",
    "node",
    "param",
    "service",
    "action",
    "lifecycle",
    "interface",
    "graph",
    "bag",
    "foxglove",
    "multicast",
    "daemon",
)

# Other names of verbs.
ALIASES = {"wtf": "doctor"}


def module_of(verb: str) -> str:
    """The full name of a verb's module."""
    return f"launcher.commands.{'ros.' if verb in ROS_VERBS else ''}{verb}"


# Verbs about a running launch. Their table is in launcher.control.verbs, which is not imported on
# the way to the first process of a run; their module is launcher.commands.control.
CONTROL_VERBS = (
    "ps",
    "top",
    "kill",
    "stop",
    "start",
    "restart",
    "reload",
    "watch",
    "pause",
    "resume",
    "mute",
    "unmute",
    "solo",
    "level",
    "loglevel",
    "grep",
    "show",
    "format",
    "logs",
    "info",
    "stack",
    "debug",
    "send",
    "events",
    "snapshot",
    "detach",
    "quit",
    "runs",
)

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
