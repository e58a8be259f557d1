"""The record of a run on a host, from which `attach` makes the run again."""

from __future__ import annotations

import getpass
import os
import re
from collections.abc import Mapping
from typing import Any

from launcher.base import strict_json
from launcher.base.model.record import Record, replace
from launcher.base.text import escape
from launcher.hosts.file import order_json
from launcher.hosts.file.order import Order

VERSION = 1
RUN_ID = "[a-z0-9]{6,8}"
_LATEST = 1e11  # a time that can be shown


class RunManifest(Record):
    """A run on one host; `started` in seconds since 1970, `orders` by process id.

    The orders have neither environment nor files: those are in the host's files already.
    """

    run: str
    title: str
    operator: str
    started: float
    orders: Mapping[int, Order]


def operator() -> str:
    """Who starts or stops a run, as other operators see it."""
    return f"{getpass.getuser()}@{os.uname().nodename}"


def encode(run: str, title: str, started: float, orders: Mapping[int, Order]) -> dict[str, Any]:
    """What is written to the host."""
    return {
        "version": VERSION,
        "run": run,
        "title": title,
        "operator": operator(),
        "started": started,
        "processes": {
            str(number): order_json.encode(replace(order, environment={}, variables={}, files={}))
            for number, order in orders.items()
        },
    }


def decode(text: str) -> RunManifest:
    """ValueError for a record of another version, or for no record.

    It comes from a host: the id of the run becomes part of a path, and texts are shown.
    """
    document = strict_json.loads(text)
    if not isinstance(document, dict) or document.get("version") != VERSION:
        raise ValueError("not a record of a run, or of another version of the launcher")
    if re.fullmatch(RUN_ID, document["run"]) is None:
        raise ValueError("not the id of a run")
    started = float(document["started"])
    if not 0 <= started < _LATEST:
        raise ValueError("not a time")
    return RunManifest(
        run=document["run"],
        title=escape(str(document["title"]), keep=""),
        operator=escape(str(document["operator"]), keep=""),
        started=started,
        orders={
            int(number): order_json.decode(order) for number, order in document["processes"].items()
        },
    )
