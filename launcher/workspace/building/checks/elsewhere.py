"""Whether the CMake files of a package may have find_package look in places of their own."""

from __future__ import annotations

import contextlib
import glob
import re
from collections.abc import Iterator

from launcher.workspace.building.sources import Package
from launcher.workspace.building.sources.source_text import SourceError, SourceText

# A word for a folder of the package, or for the folders that are searched already.
_OWN = re.compile(r"\$\{(CMAKE(_CURRENT)?_(SOURCE|LIST)_DIR|\w+_SOURCE_DIR|CMAKE_MODULE_PATH)\}")
_MODULES = re.compile(r"\b(?:set|list)\s*\(([^()]*\bCMAKE_MODULE_PATH\b[^()]*)\)")
_WORDS = ("APPEND", "PREPEND", "INSERT", "CMAKE_MODULE_PATH")


def looks_elsewhere(package: Package, name: str) -> bool:
    """Whether they name other folders, for all packages or for the one of this name."""
    places = rf"CMAKE_PREFIX_PATH|FetchContent|\b{re.escape(name)}_(DIR|ROOT)\b"
    return any(
        re.search(places, text) or not all(map(_OWN.match, _module_folders(text)))
        for text in _texts(package)
    )


def _texts(package: Package) -> Iterator[str]:
    """The texts of all CMake files of the package, without comments."""
    for pattern in ("**/CMakeLists.txt", "**/*.cmake"):
        for path in glob.glob(pattern, root_dir=package.folder, recursive=True):
            with contextlib.suppress(SourceError):
                text = SourceText(package.file(path), errors="replace").text
                yield re.sub(r"#.*", "", text)


def _module_folders(text: str) -> list[str]:
    """What a file adds to the places of modules."""
    words = (word.strip('"') for found in _MODULES.findall(text) for word in found.split())
    return [one for one in words if one not in _WORDS]
