"""Ends a run after some time: `--timeout`."""

from __future__ import annotations

from launcher.run.part import Part


class RunTimeout(Part):
    """The time counts from the start of the launch file."""

    def settled(self) -> None:
        timeout_s = self.run.options.timeout_s
        assert timeout_s is not None
        reason = f"timeout of {timeout_s:g} s reached"
        self.run.reactor.call_later(timeout_s, lambda: self.run.shutdown.stop(reason))
