"""A document of an incident, as a watched run of the fleet writes it."""

from __future__ import annotations

from typing import Any

from tests.support import watcher_stand_in

OPENED_S = 1796054845.12
NODES = ("dispatcher", "monitor", "robot_1", "robot_2", "robot_3")


def incident_document(**changes: Any) -> dict[str, Any]:
    """robot_1 is killed; its topic is silent until it is there again, 6 s later."""
    document: dict[str, Any] = {
        "format": 1,
        "number": 3,
        "run": {
            "id": "18276-0a1b2c3d",
            "pid": 18276,
            "target": "/home/me/fleet/launch/system.launch.py",
            "arguments": ["enable_debug:=true"],
            "started_wall_s": OPENED_S - 3725.4,
            "log_dir": "/home/me/.ros/log/2026-11-30-16-07-06-952698-vm-18276",
            "domain_id": 77,
        },
        "launcher": "0.9.0",
        "ros": "ROS 2 Jazzy, from wheels",
        "title": "robot_1-3 was killed by SIGKILL, so /fleet/status of robot_1 fell silent",
        "opened_s": OPENED_S,
        "closed_s": OPENED_S + 8.31,
        "faults": [
            fault(
                "no deaths: robot_1-3",
                kind="deaths",
                place=None,
                seen="robot_1-3 ended (SIGKILL)",
                expected="no process dies",
                processes=["robot_1-3"],
                nodes=["/robot_1"],
                lines=["[INFO] [1796054844.1] [robot_1]: Task deliver_dock_2 complete"],
                cause="robot_1-3 was killed by SIGKILL from outside",
                rule="killed from outside",
                first_s=OPENED_S,
                confirmed_s=OPENED_S,
            ),
            fault(
                "robot_1 reports",
                follows="no deaths: robot_1-3",
                message={"robot": "robot_1", "done": 7, "at": {"sec": 1, "nanosec": 5}},
                cause="robot_1-3, its only publisher, died 2.1 s before",
                rule="dead publisher",
            ),
            fault(
                "tasks are answered",
                kind="latency",
                follows="robot_1 reports",
                expected="below 50 ms",
                seen="95 % below 212 ms",
                topics=["/fleet/tasks"],
                state="suspected",
                confirmed_s=None,
                healed_s=None,
                muted={"reason": "known since Monday", "until_s": None},
            ),
        ],
        "causes": [
            {
                "rule": "killed from outside",
                "text": "robot_1-3 got SIGKILL, which neither a user of the launcher nor the "
                "launcher sent",
                "at_s": OPENED_S,
                "about": ["robot_1-3"],
            }
        ],
        "graphs": {"before": graph(), "after": graph(without="robot_1")},
        "topics": {
            "/fleet/status": {
                "type": "std_msgs/msg/String",
                "expected": "at least 2 Hz",
                "arrivals": [
                    OPENED_S - 20 + n * 0.4 + (n % 3) * 0.02 for n in range(100) if not 49 < n < 72
                ],
                "delays": [],
            },
            "/fleet/tasks": {
                "type": "std_msgs/msg/String",
                "expected": None,
                "arrivals": [OPENED_S - 20 + n for n in range(38)],
                "delays": [
                    [OPENED_S - 20 + n, 0.004 + (0.2 if 20 < n < 26 else 0.001 * (n % 4))]
                    for n in range(38)
                ],
            },
        },
        "processes": {
            "robot_1-3": {
                "samples": [
                    [OPENED_S - 20 + n, 3.0 + n % 4, 14.6e6 + n * 2e4]
                    for n in range(39)
                    if not 20 <= n < 27
                ]
            }
        },
        "machine": [
            [OPENED_S - 20 + n, 12 + 9 * (n % 5), 0.0, 1.5 * (n % 3), 41e9 - n * 1e6, 0.0]
            for n in range(39)
        ],
        "lines": lines(),
        "events": events(),
        "parameters": {"/robot_1": {"speed": 1.5}},
        "snapshot": None,
        "versions": {
            "launch_file": "/home/me/fleet/launch/system.launch.py",
            "hash": "9f2c1a7e5b",
            "git": "v1.4-12-gde9f33bd",
        },
    }
    return {**document, **changes}


def fault(name: str, **changes: Any) -> dict[str, Any]:
    """A fault that is healed."""
    return {
        **watcher_stand_in.fault(name),
        "state": "healed",
        "expected": "at least 2 Hz",
        "seen": "0.4 Hz",
        "value": 0.4,
        "first_s": OPENED_S + 0.9,
        "confirmed_s": OPENED_S + 2.1,
        "last_s": OPENED_S + 7.8,
        "healed_s": OPENED_S + 8.3,
        "lines": [],
        "processes": [],
        "nodes": [],
        "cause": None,
        "rule": None,
        "incident": 3,
        **changes,
    }


def graph(without: str | None = None) -> dict[str, Any]:
    """An event `graph` of the probe."""
    names = [name for name in NODES if name != without]
    pairs = [("dispatcher", "/fleet/tasks", "publisher"), ("monitor", "/fleet/report", "publisher")]
    pairs += [("monitor", "/fleet/status", "subscription")]
    for robot in ("robot_1", "robot_2", "robot_3"):
        pairs += [(robot, "/fleet/tasks", "subscription"), (robot, "/fleet/status", "publisher")]
    pairs += [("robot_1", "/robot_1/battery", "publisher")]
    endpoints = [endpoint(*pair) for pair in pairs if pair[0] != without]
    topics = sorted({one["topic"] for one in endpoints})
    return {
        "complete": True,
        "nodes": [
            {"name": f"/{name}", "hidden": False, "ghost": False, "pid": pid, "count": 1}
            for pid, name in enumerate(NODES, 18300)
            if name in names
        ],
        "topics": [{"name": name, "types": ["std_msgs/msg/String"]} for name in topics],
        "services": [],
        "endpoints": endpoints,
        "mismatches": [],
    }


def endpoint(node: str, topic: str, direction: str) -> dict[str, Any]:
    return {
        "topic": topic,
        "node": f"/{node}",
        "direction": direction,
        "type": "std_msgs/msg/String",
        "reliability": "RELIABLE",
        "durability": "VOLATILE",
        "liveliness": "AUTOMATIC",
        "deadline_ns": 2**63 - 1,
        "lease_ns": 2**63 - 1,
        "gid": "01.0f",
        "ghost": False,
    }


def lines() -> list[dict[str, Any]]:
    found = []
    for n in range(80):
        at_s = OPENED_S - 20 + n * 0.45
        level = "WARN" if n % 17 == 3 else "DEBUG" if n % 9 == 2 else "INFO"
        text = f"[{level}] [{at_s:.6f}] [robot_2]: Received task pick_shelf_{n} -- executing..."
        found.append({"wall_s": at_s, "process": "robot_2-4", "text": text})
    evidence = "[INFO] [1796054844.1] [robot_1]: Task deliver_dock_2 complete"
    found.append({"wall_s": OPENED_S - 1, "process": "robot_1-3", "text": evidence})
    for text in ("Traceback (most recent call last):", '  File "robot.py", line 4', "KeyError: 1"):
        found.append({"wall_s": OPENED_S + 1.5, "process": "monitor-2", "text": text})
    died = "[ERROR] [robot_1-3]: process has died [pid 18313, SIGKILL]"
    found.append({"wall_s": OPENED_S + 0.01, "process": None, "text": died})
    return found


def events() -> list[dict[str, Any]]:
    def event(at_s: float, name: str, process: str | None, **fields: Any) -> dict[str, Any]:
        subject = {} if process is None else {"process": process}
        return {"wall_s": OPENED_S + at_s, "monotonic_s": at_s, "event": name, **subject, **fields}

    return [
        event(-19, "started", "robot_3-5", pid=18392, restarts=0),
        event(-12, "asked", "monitor-2", verb="pause"),
        event(-10, "asked", "monitor-2", verb="resume"),
        event(0, "ended", "robot_1-3", pid=18313, returncode=-9, asked=False, restart_in_s=6.0),
        event(2.1, "fault", "robot_1-3", fault="robot_1 reports", seen="0.4 Hz", incident=3),
        event(6.1, "started", "robot_1-3", pid=18555, restarts=1),
        event(6.9, "snapshot", None, path="/x/snapshots/a", reason="robot_1-3 died (SIGKILL)"),
        event(7.2, "ready", "robot_1-3", ready_s=1.1),
    ]
