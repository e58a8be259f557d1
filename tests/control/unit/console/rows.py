"""Rows of `ps` for the tests of the console."""

from __future__ import annotations


def process(name: str, state: str = "RUNNING", **more: object) -> dict[str, object]:
    base = {
        "name": name,
        "label": name.rpartition("-")[0],
        "state": state,
        "pid": 1 if state == "RUNNING" else None,
        "restarts": 0,
        "cpu_percent": 2.4 if state == "RUNNING" else None,
        "uss_bytes": 31_000_000 if state == "RUNNING" else None,
        "namespace": "/",
        "node_names": [],
        "last_exit": None,
        "paused": False,
        "muted": False,
    }
    return {**base, **more}


FLEET = [process("dispatcher-1"), process("robot_1-2"), process("robot_2-3")]
