"""`python -m tools.quick_finders`: let editable packages of this environment start Python quickly.

Setuptools installs an editable package as a finder for imports, whose own imports take 2 ms of
every start of Python, nodes included, and 10 ms where nothing else needs them. The one written here
imports nothing and finds the same. That of setuptools stays where it would do more, for namespaces
and single modules.
"""

from __future__ import annotations

import ast
import sysconfig
from pathlib import Path

PATTERN = "__editable___*_finder.py"
FINDER = '''"""Written by tools/quick_finders.py, in place of the finder of setuptools."""

import sys
from _frozen_importlib_external import PathFinder, spec_from_file_location

MAPPING = {mapping!r}


class QuickFinder:
    @staticmethod
    def find_spec(name, path=None, target=None):
        folder = MAPPING.get(name)
        if folder is not None:
            init = folder + "/__init__.py"
            return spec_from_file_location(name, init, submodule_search_locations=[folder])
        # The working directory may have a folder of the name of the package.
        folder = MAPPING.get(name.rpartition(".")[0])
        return None if folder is None else PathFinder.find_spec(name, [folder])


def install():
    if QuickFinder not in sys.meta_path:
        sys.meta_path.append(QuickFinder)
'''


def replace(folder: Path) -> list[str]:
    """Replace the finders in a folder of packages; the names of the packages that they find."""
    packages: list[str] = []
    for path in sorted(folder.glob(PATTERN)):
        values = _values(path.read_text(encoding="utf-8"))
        mapping = values.get("MAPPING")
        is_plain = values.get("NAMESPACES") == {}
        if is_plain and mapping and all(map(_is_package, mapping.values())):
            path.write_text(FINDER.format(mapping=mapping), encoding="utf-8")
            packages += mapping
    return packages


def _is_package(folder: str) -> bool:
    return Path(folder, "__init__.py").is_file()


def _values(text: str) -> dict[str, dict[str, str]]:
    """The dictionaries that a finder begins with; none of one that is replaced already."""
    found = {}
    for node in ast.parse(text).body:
        if isinstance(node, ast.AnnAssign) and isinstance(node.value, ast.Dict):
            found[ast.unparse(node.target)] = ast.literal_eval(node.value)
    return found


if __name__ == "__main__":
    replace(Path(sysconfig.get_path("purelib")))
