"""Which packages of a workspace are tested."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from launcher.base.errors import LauncherError, SeveralErrors, UsageError
from launcher.base.text import did_you_mean
from launcher.workspace.building import sources
from launcher.workspace.building.place import Place
from launcher.workspace.building.sources import Package


def select(place: Place, names: Sequence[str], env: Mapping[str, str]) -> list[Package]:
    """The packages of these names, by default those that the place names, or all.

    UsageError for unknown names, and for packages that cannot be read.
    """
    found = sources.find([place.base], env)
    known = {package.name: package for package in found.packages}
    errors: list[LauncherError] = [
        UsageError(
            f"no package '{name}' in {place.base}",
            hint=did_you_mean(name, known) or f"packages: {', '.join(known) or 'none'}",
        )
        for name in names
        if name not in known
    ]
    if errors or (found.errors and not names):
        raise SeveralErrors([*errors, *found.errors])
    if names:
        return [known[name] for name in dict.fromkeys(names)]
    return [one for one in found.packages if not place.named or one.folder in place.named]
