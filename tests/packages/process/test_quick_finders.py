"""The finders that `make` puts in place of those of setuptools for editable packages."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tools.quick_finders import replace

# As setuptools writes it.
FINDER = """
from __future__ import annotations
from pathlib import Path

MAPPING: dict[str, str] = {mapping!r}
NAMESPACES: dict[str, list[str]] = {namespaces!r}

def install():
    raise SystemExit("setuptools")
"""
PROGRAM = """
import site, sys
site.addsitedir({site!r})
assert "pathlib" not in sys.modules
import pkg.below, other
print(pkg.__file__, pkg.__path__, pkg.below.__file__, other.NAME)
"""


def installation(folder: Path, mapping: dict[str, str], namespaces: object = None) -> Path:
    site = folder / "site"
    site.mkdir()
    text = FINDER.format(mapping=mapping, namespaces=namespaces or {})
    (site / "__editable___pkg_finder.py").write_text(text)
    line = "import __editable___pkg_finder; __editable___pkg_finder.install()\n"
    (site / "__editable__.pkg.pth").write_text(line)
    return site


def test_packages_are_found_where_they_were_and_nothing_is_imported_for_it(tmp_path: Path):
    mapping = {}
    for name in ("pkg", "other"):
        folder = tmp_path / f"src of {name}" / name
        folder.mkdir(parents=True)
        (folder / "__init__.py").write_text(f"NAME = {name!r}\n")
        (folder / "below.py").touch()
        mapping[name] = str(folder)
    site = installation(tmp_path, mapping)
    (tmp_path / "elsewhere/other").mkdir(parents=True)  # of the same name, and no package

    assert (replace(site), replace(site)) == (["pkg", "other"], [])

    said = subprocess.check_output(
        [sys.executable, "-I", "-S", "-c", PROGRAM.format(site=str(site))],
        cwd=tmp_path / "elsewhere",
        text=True,
        timeout=60,
    )
    source = mapping["pkg"]
    assert said == f"{source}/__init__.py ['{source}'] {source}/below.py other\n"


@pytest.mark.parametrize("namespaces", [{}, {"pkg": ["/src/pkg"]}], ids=["module", "namespace"])
def test_the_finder_of_a_module_or_namespace_stays(tmp_path: Path, namespaces: object):
    site = installation(tmp_path, {"pkg": str(tmp_path / "pkg")}, namespaces)
    if namespaces:
        (tmp_path / "pkg").mkdir()
        (tmp_path / "pkg/__init__.py").touch()
    before = (site / "__editable___pkg_finder.py").read_text()
    assert replace(site) == []
    assert (site / "__editable___pkg_finder.py").read_text() == before
