"""The words of a command line that rcl reads: those between `--ros-args` and `--`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

REMAP, PARAMETER, PARAMETER_FILE = "-r", "-p", "--params-file"
_OPTIONS = {
    "-r": REMAP,
    "--remap": REMAP,
    "-p": PARAMETER,
    "--param": PARAMETER,
    "--params-file": PARAMETER_FILE,
}
# Others with a word behind them, which is not an option itself.
_SKIPPED = ("--log-level", "--log-config-file", "--log-file-name", "-e", "--enclave")


def ros_options(argv: Iterable[str]) -> Iterator[tuple[str, str]]:
    """(option, value) of each remapping, parameter and parameter file, in order."""
    is_inside = False
    words = iter(argv)
    for word in words:
        if word == "--ros-args":
            is_inside = True
        elif is_inside and word == "--":
            is_inside = False
        elif is_inside and word in _OPTIONS:
            value = next(words, None)
            if value is not None:
                yield _OPTIONS[word], value
        elif is_inside and word in _SKIPPED:
            next(words, None)


def full_node_name(argv: Sequence[str]) -> str | None:
    """`/ns/name` by the remappings; None if the name is that of the program itself.

    Of several rules rcl takes the first. Rules for one of several nodes are not considered.
    """
    found: dict[str, str] = {}
    for option, value in ros_options(argv):
        target, _, name = value.partition(":=")
        if option is REMAP:
            found.setdefault({"__name": "__node"}.get(target, target), name)
    if "__node" not in found:
        return None
    return f"/{found.get('__ns', '').strip('/')}/{found['__node']}".replace("//", "/")
