"""Entries of a journal, as journalctl prints them."""

from __future__ import annotations

import json


def entry(**fields: object) -> bytes:
    general = {"__CURSOR": "c1", "__MONOTONIC_TIMESTAMP": "2500000", "_UID": "0"}
    return json.dumps({**general, **fields}).encode() + b"\n"
