"""The files of the page: ours in `page/`, and the libraries that the wheel of NiceGUI ships.

NiceGUI itself is not imported: only its files are used, which are found without it.
"""

from __future__ import annotations

import importlib.util
import mimetypes
import re
from functools import cache
from pathlib import Path

from launcher.base import strict_json
from launcher.base.errors import LauncherError

PAGE = Path(__file__).with_name("page")
_ICONS = re.compile(r'font-family: "Material Icons";[^}]*?url\(fonts/([\w.-]+\.woff2)\)')
_IMPORT = re.compile(r'^(?:import|export|\}).*from "page/([\w./-]+)";$', re.MULTILINE)
# Name on the page -> file in the folder of the package nicegui.
_LIBRARIES = {
    "vue.js": "static/vue.esm-browser.prod.js",
    "quasar.js": "static/quasar.umd.prod.js",
    "quasar.css": "static/quasar.unimportant.prod.css",
    "quasar-important.css": "static/quasar.important.prod.css",
}
_ECHARTS = "elements/echart/dist"
MODULES = {"vue": "/lib/vue.js", "echarts": "/lib/echarts/index.js", "page/": "/page/"}
_TYPES = {".js": "text/javascript", ".css": "text/css", ".woff2": "font/woff2"}


@cache
def _nicegui() -> Path:
    spec = importlib.util.find_spec("nicegui")
    if spec is None or not spec.submodule_search_locations:
        raise LauncherError("the page needs the files of the Python package 'nicegui'")
    return Path(spec.submodule_search_locations[0])


@cache
def libraries() -> dict[str, Path]:
    """Files below `/lib/` by their names there; LauncherError if one is missing."""
    root = _nicegui()
    found = {name: root / path for name, path in _LIBRARIES.items()}
    found.update({f"echarts/{path.name}": path for path in (root / _ECHARTS).glob("*.js")})
    icons = _ICONS.search((root / "static/fonts.css").read_text(encoding="utf-8"))
    if icons is not None:
        found["icons.woff2"] = root / "static/fonts" / icons[1]
    missing = [name for name, path in found.items() if not path.is_file()]
    wanted = {"icons.woff2", "echarts/index.js"} - found.keys()
    if missing or wanted:
        names = ", ".join(sorted({*missing, *wanted}))
        raise LauncherError(
            f"the package 'nicegui' in {root} lacks files of the page: {names}",
            hint="install the version that requirements/dev.txt names",
        )
    return found


def content(path: Path) -> tuple[bytes, str]:
    """(bytes, media type) of a file of the page."""
    suffix = path.suffix
    kind = _TYPES.get(suffix) or mimetypes.guess_type(path.name)[0] or "application/octet-stream"
    return path.read_bytes(), kind


def own_files() -> dict[str, Path]:
    """Files below `/page/` by their names there, without HTML files."""
    return {
        path.relative_to(PAGE).as_posix(): path
        for path in sorted(PAGE.rglob("*"))
        if path.is_file() and path.suffix != ".html"
    }


def import_map() -> str:
    """What the browser resolves the bare names of modules with."""
    return strict_json.dumps({"imports": MODULES}, sort_keys=True)


def index(feed_key: str) -> str:
    """The page's HTML, with the import map and what the browser may load at once."""
    text = (PAGE / "index.html").read_text(encoding="utf-8")
    names = sorted(_first_modules())
    preloads = "\n    ".join(f'<link rel="modulepreload" href="/page/{name}">' for name in names)
    return (
        text.replace("IMPORT_MAP", import_map())
        .replace("<!-- PRELOADS -->", preloads)
        .replace("FEED_KEY", feed_key)
    )


@cache
def _first_modules() -> frozenset[str]:
    """Our modules that the first picture needs: the browser would find them one after the other."""
    found: set[str] = set()
    waiting = {"main.js", "app.js", "processes/panel.js"}
    while waiting:
        name = waiting.pop()
        found.add(name)
        text = (PAGE / name).read_text(encoding="utf-8")
        waiting |= set(_IMPORT.findall(text)) - found
    return frozenset(found)
