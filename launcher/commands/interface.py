"""`interface VERB ...`: the message, service and action types that are installed."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable, Sequence

from launcher.errors import ExitCode
from launcher.ros.verb import Parser, add_verb, dispatch, parser_of, print_json

_TITLES = {"msg": "Messages:", "srv": "Services:", "action": "Actions:"}


def main(words: Sequence[str]) -> int:
    """Run one `interface` command; the exit code."""
    return dispatch(build_parser(), _RUN, words)


def build_parser() -> Parser:
    """The options of every sub-verb."""
    parser, table = parser_of("interface", "Look at installed types.")
    sub = add_verb(table, "list", "names of all types")
    sub.add_argument("-m", "--only-msgs", action="store_true", help="only messages")
    sub.add_argument("-s", "--only-srvs", action="store_true", help="only services")
    sub.add_argument("-a", "--only-actions", action="store_true", help="only actions")
    sub = add_verb(table, "show", "definition of a type")
    sub.add_argument("type", metavar="TYPE", help="- reads it from stdin")
    comments = sub.add_mutually_exclusive_group()
    comments.add_argument("--all-comments", action="store_true", help="of nested types as well")
    comments.add_argument("--no-comments", action="store_true", help="no comments, no empty lines")
    sub = add_verb(table, "proto", "a type as YAML to fill in")
    sub.add_argument("type", metavar="TYPE")
    sub.add_argument("--no-quotes", action="store_true", help="no quotes around the YAML")
    return parser


def _list(options: Namespace) -> int:
    from launcher.ros.messages.interfaces import all_interfaces

    asked = (options.only_msgs, options.only_srvs, options.only_actions)
    kinds = [kind for kind, wanted in zip(_TITLES, asked, strict=True) if wanted] or list(_TITLES)
    found = {kind: all_interfaces([kind]) for kind in kinds}
    if options.json:
        print_json(found)
        return ExitCode.OK
    for kind, names in found.items():
        print(_TITLES[kind])
        for name in names:
            print(f"    {name}")
    return ExitCode.OK


def _show(options: Namespace) -> int:
    from launcher.ros.messages.interfaces import resolve, show

    name = sys.stdin.readline().strip() if options.type == "-" else options.type
    full = resolve(name)
    lines = list(show(full, comments=not options.no_comments, nested_comments=options.all_comments))
    if options.json:
        print_json({"name": full, "definition": lines})
    else:
        print("\n".join(lines))
    return ExitCode.OK


def _proto(options: Namespace) -> int:
    from launcher.ros.messages.interfaces import load, resolve
    from launcher.ros.messages.to_yaml import to_json_plain, to_plain, to_yaml

    full = resolve(options.type)
    kind = full.split("/")[1]
    cls = load(full, kind, f"Unknown interface '{full}'")
    message = {"msg": lambda: cls(), "srv": lambda: cls.Request(), "action": lambda: cls.Goal()}
    made = message[kind]()
    if options.json:
        print_json(to_json_plain(to_plain(made)))
    else:
        text = to_yaml(made)
        print(text if options.no_quotes else f'"{text}"')
    return ExitCode.OK


_RUN: dict[str, Callable[[Namespace], int]] = {"list": _list, "show": _show, "proto": _proto}
