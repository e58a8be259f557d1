"""Smoke tests of launch files: start a system, observe it from outside, stop it, judge.

May import the core, `bag`, `hosts`, `ros`, `web` and `workspace`. Never imports rclpy: a separate
process observes ROS (`launcher.ros.probe`).

Doors: `verb` (`smoke`); `System` and `NotSeenError`, for tests in Python; `pytest_plugin`, with
the fixture `launched_system`.

Folders, in the order of a run:

* `expect/`: the expectation file: its grammar, its schema, and a `script` of what it contains.
  `evaluation` is a process
  that evaluates `where` and `fields` with limits of time and memory: Python itself would not end
  `sum(range(10**12))`. The kernel ends it when smoke has ended, even in the middle of a
  computation.
* `preflight/`: loads the file, and finds impossible expectations before anything is started.
* `run/`: a command, its runs, and the systems that they launch, each in a separate domain.
* `observe/`: records facts, from the control socket, log files and the probe; `topic_recording` is
  a bag, for the expectation `like`, which compares it with another one.
* `judges/`: pure functions (expectation, facts) -> verdict.
* `reports/`: results for people, for CI and for the next run, and the evidence.
* `launch_tests/`: launch_testing and launch_pytest, which run in the process of the tests.
* `inject/`: faults that are made on purpose: the verb `inject`, steps of a scenario, and a seeded
  plan of them (`--chaos`).
* `record/`: writes expectations from what healthy runs showed.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.smoke.run.system import System
    from launcher.smoke.run.waits import NotSeenError

__all__ = ["NotSeenError", "System"]


def __getattr__(name: str) -> Any:
    """Import what they need when they are used: pytest loads the plugin in every run."""
    if name == "System":
        from launcher.smoke.run.system import System

        return System
    if name == "NotSeenError":
        from launcher.smoke.run.waits import NotSeenError

        return NotSeenError
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
