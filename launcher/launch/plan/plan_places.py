"""Where processes of a plan run, for a plan with a hosts file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from launcher.base.errors import LauncherError
    from launcher.launch.plan.plan import Plan


class Placed(Protocol):
    """The place of one process."""

    @property
    def is_here(self) -> bool: ...

    # `bot1`; `bot1 (skipped)` where it is not started.
    @property
    def shown(self) -> str: ...

    # The lines below it in the tree, with their styles, and its entries in the document. Both get
    # the environment of the launch, and that of the process.
    def lines(
        self, environment: Mapping[str, str], env: Mapping[str, str]
    ) -> list[tuple[str, str]]: ...
    def document(
        self, environment: Mapping[str, str], env: Mapping[str, str]
    ) -> dict[str, Any]: ...


class PlanPlaces(Protocol):
    """The hosts of a plan, or how its nodes find each other."""

    # Find the places of its processes; before the rest is asked for.
    def place(self, plan: Plan) -> None: ...

    # By the number of the process in the plan; empty without hosts.
    @property
    def placed(self) -> Sequence[Placed]: ...
    @property
    def errors(self) -> Sequence[LauncherError]: ...
    @property
    def warnings(self) -> Sequence[str]: ...

    # How nodes find each other, in the document, and as a line; empty if that is not set.
    def discovery_document(self) -> dict[str, Any] | None: ...
    def discovery_line(self) -> str: ...

    # The variables with which a crowd of nodes on this machine finds each other; None if it has no
    # limit.
    def crowd_environment(self) -> Mapping[str, str] | None: ...
