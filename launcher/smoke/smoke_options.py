"""Single expectations as options of the command line, named like the entries of a file.

`--expect-KIND` is a kind with its subject and perhaps one entry, `--expect-KIND-ENTRY` one with
another entry.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial

from launcher.base.option import Option, option

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.smoke.expect.expectation import Expectation

Entry = dict[str, object]

_OF_PROCESS = re.compile(r"([\w*?/.\[\]-]+): +(.+)", re.DOTALL)


def _keys(
    first: str, second: str, read: Callable[[str], object] = str, **more: object
) -> Callable[[str], Entry]:
    """`A=B` as an entry with two keys and their values; `A` with the first one alone."""

    def entry(text: str) -> Entry:
        subject, equals, value = (part.strip() for part in text.partition("="))
        return {first: subject, **({second: read(value)} if equals else {}), **more}

    return entry


def _number(text: str) -> object:
    return int(text) if text.isdigit() else text


def _policies(text: str) -> object:
    pairs = (policy.partition(":") for policy in text.split(","))
    return {name.strip(): value.strip() for name, _, value in pairs}


def _log(text: str) -> Entry:
    match = _OF_PROCESS.fullmatch(text)
    return {"log": text} if match is None else {"log": match[2], "process": match[1]}


def _log_count(text: str) -> Entry:
    pattern, _, number = text.rpartition("=")
    return {**_log(pattern), "count": _number(number.strip())}


def _parameter(text: str) -> Entry:
    from launcher.base.model.parameter_text import read

    place, _, value = text.partition("=")
    node, colon, name = place.strip().rpartition(":")
    if not colon:
        raise ValueError(f"'{text}' has no ':' after the node")
    return {"parameter": name, "node": node, "is": read(value.strip())}


def _expectation(spelling: str, help_text: str, entry: Callable[[str], Entry]) -> Option:
    flag, _, metavar = spelling.partition("[=")[0].partition(" ")

    def read(text: str) -> Expectation:
        if "=" in metavar and not text.partition("=")[2].strip():
            raise ValueError(f"'{text}' is not {metavar}")
        from launcher.smoke.preflight.loader import parse_entry

        return parse_entry(entry(text), f"{flag} {text}".strip())

    value = partial(read, "") if spelling == flag else None
    return option(spelling, help_text, read, (), name="expectations", repeat="all", value=value)


EXPECTATIONS = (
    _expectation("--expect-node NAME[=WITHIN]", "a node exists", _keys("node", "within")),
    _expectation("--expect-topic TOPIC[=TYPE]", "a topic exists", _keys("topic", "type")),
    _expectation(
        "--expect-topic-publishers TOPIC=COUNT",
        "number of publishers",
        _keys("topic", "publishers", _number),
    ),
    _expectation(
        "--expect-topic-subscriptions TOPIC=COUNT",
        "number of subscriptions",
        _keys("topic", "subscriptions", _number),
    ),
    _expectation(
        "--expect-qos-publishers TOPIC=POLICY:VALUE,...",
        "QoS of all publishers",
        _keys("qos", "publishers", _policies),
    ),
    _expectation(
        "--expect-rate TOPIC=RATE", "as in '/fleet/tasks=1 Hz ± 20 %'", _keys("rate", "is")
    ),
    _expectation(
        "--expect-message TOPIC[=WHERE]", "true for one message", _keys("message", "where")
    ),
    _expectation(
        "--expect-message-all TOPIC=WHERE",
        "true for all messages",
        _keys("message", "where", all=True),
    ),
    _expectation("--expect-log REGEX", "a line matches, as in 'monitor: Fleet report'", _log),
    _expectation(
        "--expect-log-count REGEX=COUNT",
        "number of lines that match, as in 'monitor: Traceback=0'",
        _log_count,
    ),
    _expectation(
        "--expect-process PROCESS[=EXITS]",
        "it runs until the end, or exits with this code or signal",
        _keys("process", "exits", _number),
    ),
    _expectation(
        "--expect-process-restarts PROCESS=COUNT",
        "number of restarts",
        _keys("process", "restarts", _number),
    ),
    _expectation("--expect-ready PROCESS[=WITHIN]", "it is ready", _keys("ready", "within")),
    _expectation("--expect-parameter NODE:PARAMETER=VALUE", "value of a parameter", _parameter),
    _expectation("--expect-service SERVICE[=TYPE]", "a service exists", _keys("service", "type")),
    _expectation("--expect-cpu PROCESS=BELOW", "average CPU, in percent", _keys("cpu", "below")),
    _expectation("--expect-memory PROCESS=BELOW", "as in '200 MB'", _keys("memory", "below")),
    _expectation("--expect-start-up S", "time until all is ready", lambda s: {"start_up": s}),
    _expectation("--expect-clean-shutdown S", "time to stop", lambda s: {"clean_shutdown": s}),
    _expectation(
        "--expect-no-errors[=PROCESS]", "no ERROR or FATAL line", lambda s: {"no_errors": s or "*"}
    ),
    _expectation(
        "--expect-no-tracebacks[=PROCESS]", "no traceback", lambda s: {"no_tracebacks": s or "*"}
    ),
    _expectation(
        "--expect-shared-memory",
        "nothing is left in /dev/shm",
        lambda _: {"shared_memory": "clean"},
    ),
)
