"""The plan of a run, in its folder, and warnings of options that match nothing in it."""

from __future__ import annotations

from launcher.run.part import Part

DELAY_S = 0.1  # the plan is not urgent, and processes are still starting before


class PlanFile(Part):
    """Written when the first processes have been started, and at the end."""

    def settled(self) -> None:
        when_idle = self.run.reactor.when_idle
        self.run.reactor.call_later(DELAY_S, lambda: when_idle(self._write))

    def conclude(self, *, is_orderly: bool) -> None:
        self._write()

    def _write(self) -> None:
        run = self.run
        run.directory.write_plan(run.core.plan)
        if run.options.name_processes:
            from launcher.run.option_warnings import warn_of_unmatched

            specs = [process.spec for process in run.all_processes.values()]
            specs += run.launched.switched_off()
            warn_of_unmatched(run.options, specs, run.log, is_over=run.shutdown.has_begun)
