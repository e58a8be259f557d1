"""`interface VERB ...`: list and show the installed message, service and action types."""

from __future__ import annotations

import functools
import itertools
import os
import sys

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import option
from launcher.base.text import did_you_mean
from launcher.base.verb_table import VERBS
from launcher.packages import unbuilt
from launcher.ros.verb import dispatch, ros_command, show, warn

KINDS = (
    option("-m, --only-msgs", "only messages"),
    option("-s, --only-srvs", "only services"),
    option("-a, --only-actions", "only actions"),
)
_TITLES = {"msg": "Messages:", "srv": "Services:", "action": "Actions:"}


def _list(options: Parsed) -> int:
    from launcher.ros.messages.interfaces import all_interfaces

    _warn_of_none()
    found = {kind: all_interfaces([kind]) for kind in _kinds(options)}
    lines = ([_TITLES[kind], *(f"    {name}" for name in found[kind])] for kind in found)
    names = [*itertools.chain.from_iterable(found.values())]
    return show(options, {"interfaces": names}, itertools.chain.from_iterable(lines))


def _show(options: Parsed) -> int:
    from launcher.ros.messages.interfaces import note_of_change, resolve
    from launcher.ros.messages.interfaces import show as definition

    name = sys.stdin.readline().strip() if options.type == "-" else options.type
    full = resolve(name)
    lines = list(
        definition(full, comments=not options.no_comments, nested_comments=options.all_comments)
    )
    show(options, {"name": full, "definition": lines}, lines)
    if note := note_of_change(full):
        warn(note)
    return ExitCode.OK


def _package(options: Parsed) -> int:
    from launcher.base.ros_errors import VerbError
    from launcher.ros.messages.interfaces import (
        interface_packages,
        interfaces_of,
        none_installed,
    )

    name = options.package
    known = interface_packages()
    if name not in known:
        hint = unbuilt.hint(name, os.environ) or none_installed() or did_you_mean(name, known)
        raise VerbError(f"Unknown package '{name}'", hint=hint)
    found = interfaces_of(name, _kinds(options))
    return show(options, {"package": name, "interfaces": found}, found)


def _packages(options: Parsed) -> int:
    from launcher.ros.messages.interfaces import interface_packages, interfaces_of

    _warn_of_none()
    kinds = _kinds(options)
    found = [name for name in interface_packages() if interfaces_of(name, kinds)]
    return show(options, {"packages": found}, found)


def _warn_of_none() -> None:
    from launcher.ros.messages.interfaces import none_installed

    if hint := none_installed():
        warn(f"hint: {hint}")


def _kinds(options: Parsed) -> list[str]:
    asked = (options.only_msgs, options.only_srvs, options.only_actions)
    return [kind for kind, wanted in zip(_TITLES, asked, strict=True) if wanted] or list(_TITLES)


def _proto(options: Parsed) -> int:
    from launcher.ros.messages.interfaces import load, resolve
    from launcher.ros.messages.to_yaml import to_plain, to_yaml

    full = resolve(options.type)
    kind = full.split("/")[1]
    cls = load(full, kind, f"Unknown interface '{full}'")
    message = {"msg": lambda: cls(), "srv": lambda: cls.Request(), "action": lambda: cls.Goal()}
    made = message[kind]()
    text = to_yaml(made)
    quoted = text if options.no_quotes else f'"{text}"'
    return show(options, {"name": full, "message": to_plain(made)}, [quoted])


COMMAND = Command(
    "interface",
    VERBS["interface"],
    commands=(
        ros_command(
            "interface list",
            "list types",
            _list,
            *KINDS,
        ),
        ros_command(
            "interface package",
            "list the types of a package",
            _package,
            option("PACKAGE"),
            *KINDS,
        ),
        ros_command("interface packages", "list the packages that have types", _packages, *KINDS),
        ros_command(
            "interface show",
            "print the definition of a type",
            _show,
            option("TYPE", "name of the type; `-` reads it from stdin"),
            option("--all-comments", "comments of nested types as well"),
            option("--no-comments", "no comments and no empty lines"),
            exclusive=(("all_comments", "no_comments"),),
        ),
        ros_command(
            "interface proto",
            "print a type as YAML to fill in",
            _proto,
            option("TYPE"),
            option("--no-quotes", "no quotes around the YAML"),
        ),
    ),
)

main = functools.partial(dispatch, COMMAND)
