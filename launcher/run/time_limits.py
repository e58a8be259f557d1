"""Ends a run after some time: `--timeout`, or some time without output: `--stop-after-quiet`."""

from __future__ import annotations

from launcher.run.part import Part


class RunTimeout(Part):
    """The time counts from the start of the launch file."""

    def settled(self) -> None:
        timeout_s = self.run.options.timeout_s
        assert timeout_s is not None
        reason = f"timeout of {timeout_s:g} s reached"
        self.run.reactor.call_later(timeout_s, lambda: self.run.shutdown.stop(reason))


class QuietLimit(Part):
    """The time counts from the start of the launch file, and again from each output."""

    def settled(self) -> None:
        self._begun_s = self.run.reactor.now()
        self._check()

    def _check(self) -> None:
        quiet_s = self.run.options.stop_after_quiet_s
        assert quiet_s is not None
        since_s = max(self._begun_s, self.run.reader.read_at_s)
        left_s = since_s + quiet_s - self.run.reactor.now()
        if left_s > 0:
            self.run.reactor.call_later(left_s, self._check)
        else:
            self.run.shutdown.stop(f"no output for {quiet_s:g} s")
