"""Flags: single expectations as options of the command line; each is an entry of a file."""

from __future__ import annotations

import re
from collections.abc import Callable

from launcher.errors import UsageError
from launcher.smoke.expectation import Expectation
from launcher.smoke.loader import parse_entry

Entry = dict[str, object]

_OF_PROCESS = re.compile(r"([\w*?/.\[\]-]+): +(.+)", re.DOTALL)

HELP = """\
  --expect-node NAME[=WITHIN]         --expect-topic TOPIC[=TYPE]
  --expect-publishers TOPIC=COUNT     --expect-subscriptions TOPIC=COUNT
  --expect-qos TOPIC=POLICY:VALUE,... of all its publishers
  --expect-rate TOPIC=RATE            '/fleet/tasks=1 Hz ± 20 %'
  --expect-message TOPIC[=EXPRESSION] --expect-all TOPIC=EXPRESSION
  --expect-log [PROCESS:] REGEX       'monitor: Fleet report'
  --forbid-log [PROCESS:] REGEX
  --expect-alive PROCESS              --expect-exit PROCESS=CODE
  --expect-parameter NODE:NAME=VALUE  --expect-service SERVICE[=TYPE]
  --max-cpu PROCESS=PERCENT           --max-memory PROCESS=SIZE
  --max-start-up S                    --max-shutdown S
  --no-errors [=PROCESS]              --no-tracebacks [=PROCESS]
  --clean-shared-memory"""


def _pair(text: str, flag: str, second: str) -> tuple[str, str]:
    first, equals, rest = text.partition("=")
    if not equals or not rest.strip():
        raise UsageError(f"{flag} {text}: a '=' and {second} are missing", hint=_line_of(flag))
    return first.strip(), rest.strip()


def _line_of(flag: str) -> str:
    pattern = re.compile(rf"{flag} .*?(?=  +|$)")
    return next((m[0] for line in HELP.splitlines() if (m := pattern.search(line))), flag)


def _optional(text: str) -> tuple[str, str | None]:
    first, equals, rest = text.partition("=")
    return first.strip(), rest.strip() if equals else None


def _node(text: str) -> Entry:
    name, within = _optional(text)
    return {"node": name} if within is None else {"node": name, "within": within}


def _topic(text: str) -> Entry:
    topic, type_ = _optional(text)
    return {"topic": topic} if type_ is None else {"topic": topic, "type": type_}


def _count(side: str) -> Callable[[str], Entry]:
    def entry(text: str) -> Entry:
        topic, count = _pair(text, f"--expect-{side}", "a count")
        return {"topic": topic, side: _number(count)}

    return entry


def _number(text: str) -> object:
    return int(text) if text.isdigit() else text


def _qos(text: str) -> Entry:
    topic, policies = _pair(text, "--expect-qos", "policies")
    pairs = (policy.partition(":") for policy in policies.split(","))
    return {"qos": topic, "publishers": {name.strip(): value.strip() for name, _, value in pairs}}


def _rate(text: str) -> Entry:
    topic, rate = _pair(text, "--expect-rate", "a rate")
    return {"rate": topic, "is": rate}


def _message(text: str) -> Entry:
    topic, expression = _optional(text)
    return {"message": topic} if expression is None else {"message": topic, "where": expression}


def _all(text: str) -> Entry:
    topic, expression = _pair(text, "--expect-all", "an expression")
    return {"message": topic, "where": expression, "all": True}


def _log(text: str) -> Entry:
    match = _OF_PROCESS.fullmatch(text)
    return {"log": text} if match is None else {"log": match[2], "process": match[1]}


def _exit(text: str) -> Entry:
    process, code = _pair(text, "--expect-exit", "an exit code")
    return {"process": process, "exits": _number(code)}


def _parameter(text: str) -> Entry:
    import yaml

    place, value = _pair(text, "--expect-parameter", "a value")
    node, colon, name = place.rpartition(":")
    if not colon:
        flag = "--expect-parameter"
        raise UsageError(f"{flag} {text}: a ':' behind the node is missing", hint=_line_of(flag))
    return {"parameter": name, "node": node, "is": yaml.safe_load(value)}


def _service(text: str) -> Entry:
    service, type_ = _optional(text)
    return {"service": service} if type_ is None else {"service": service, "type": type_}


def _limit(kind: str, flag: str) -> Callable[[str], Entry]:
    def entry(text: str) -> Entry:
        process, limit = _pair(text, flag, "a limit")
        return {kind: process, "below": limit}

    return entry


VALUED: dict[str, Callable[[str], Entry]] = {
    "--expect-node": _node,
    "--expect-topic": _topic,
    "--expect-publishers": _count("publishers"),
    "--expect-subscriptions": _count("subscriptions"),
    "--expect-qos": _qos,
    "--expect-rate": _rate,
    "--expect-message": _message,
    "--expect-all": _all,
    "--expect-log": _log,
    "--forbid-log": lambda text: {**_log(text), "count": 0},
    "--expect-alive": lambda text: {"process": text, "alive": True},
    "--expect-exit": _exit,
    "--expect-parameter": _parameter,
    "--expect-service": _service,
    "--max-cpu": _limit("cpu", "--max-cpu"),
    "--max-memory": _limit("memory", "--max-memory"),
    "--max-start-up": lambda text: {"start_up": text},
    "--max-shutdown": lambda text: {"clean_shutdown": text},
}
# A value may follow a '=', never stand in a word of its own.
PLAIN: dict[str, Callable[[str], Entry]] = {
    "--no-errors": lambda text: {"no_errors": text or "*"},
    "--no-tracebacks": lambda text: {"no_tracebacks": text or "*"},
    "--clean-shared-memory": lambda text: {"shared_memory": "clean"},
}


def expectation_of(flag: str, text: str) -> Expectation:
    """The expectation that an option stands for; UsageError."""
    entry = {**VALUED, **PLAIN}[flag](text)
    return parse_entry(entry, f"{flag} {text}".strip())
