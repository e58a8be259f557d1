"""Where the links of an `install/` lead, which a copied or moved workspace keeps."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

from launcher.packages.environment import packages
from launcher.packages.hooks import read_text
from launcher.packages.sources import MARKERS
from launcher.packages.workspace import Workspace

# In setup.sh: the `install/` that it was made for.
_BUILT = re.compile(r"^_colcon_prefix_chain_sh_COLCON_CURRENT_PREFIX=(/.*)$", re.MULTILINE)


def built_elsewhere(workspace: Workspace) -> str | None:
    """The root of another workspace that the links of this one lead to: it was moved or copied."""
    found = _BUILT.search(read_text(os.path.join(workspace.install, "setup.sh")) or "")
    if found is None or os.path.realpath(found[1]) == os.path.realpath(workspace.install):
        return None
    root = os.path.dirname(found[1])
    for name, prefix in packages(workspace.install).items():
        if any(target.startswith(f"{root}/") for _, target in _links(prefix, name)):
            return root
    return None


def dead_link(prefix: str, package: str) -> str | None:
    """What a link of an installed package leads to, though it does not exist; None if all do."""
    return next((path for link, path in _links(prefix, package) if not os.path.exists(link)), None)


def _links(prefix: str, package: str) -> Iterator[tuple[str, str]]:
    """(link, its target) for those that every linked package has."""
    for place in (os.path.join("share", package, "package.xml"), os.path.join(MARKERS, package)):
        link = os.path.join(prefix, place)
        if os.path.islink(link):
            yield link, os.readlink(link)
