"""`--private`: a ROS domain that only this run has, which was leased before the evaluation."""

from __future__ import annotations

from launcher.base.errors import UsageError
from launcher.run.part import Part

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

    from launcher.base.model.run_options import RunOptions


class PrivateDomain(Part):
    """Says which domain it is, before the first process."""

    def open(self, begin: Callable[[], None]) -> bool:
        domain = self.run.options.domain_id
        text = f"this run has ROS domain {domain} for itself; in other shells: "
        text += f"export ROS_DOMAIN_ID={domain}, or --domain {domain} behind a verb"
        self.run.log.log("INFO", "launch", text)
        return False


def check(options: RunOptions) -> None:
    """UsageError where the domain is free only here."""
    if options.private and options.hosts is not None:
        hint = "set ROS_DOMAIN_ID to a domain that is free on all hosts"
        raise UsageError("--private and --hosts exclude each other", hint=hint)
