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
from launcher.web import page_bundle

PAGE = Path(__file__).with_name("page")
_ICONS = re.compile(r'font-family: "Material Icons";[^}]*?url\(fonts/([\w.-]+\.woff2)\)')
STYLE_SHEET = re.compile(r' *<link rel="stylesheet" href="/(lib|page)/([^"]+)">\n')
JOINED_STYLES = "page.css"
_MARK = "<!-- STYLES -->"
# Workers run a file by itself.
_ALONE = frozenset({"log/search_worker.js"})
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
    """The page's HTML, with the import map and one style sheet in place of all."""
    text = (PAGE / "index.html").read_text(encoding="utf-8")
    link = f'    <link rel="stylesheet" href="/page/{JOINED_STYLES}">\n'
    text = STYLE_SHEET.sub("", STYLE_SHEET.sub(_MARK, text, count=1)).replace(_MARK, link)
    return text.replace("IMPORT_MAP", import_map()).replace("FEED_KEY", feed_key)


def joined_files() -> dict[str, tuple[bytes, str]]:
    """(bytes, media type) of what is served below `/page/` and is no file as it is.

    The modules are in one script, and the style sheets in one: in a new browser each request
    takes longer than what it brings.
    """
    modules = {
        name: page_bundle.module_of(path.read_text(encoding="utf-8"))
        for name, path in own_files().items()
        if name.endswith(".js") and name not in _ALONE
    }
    scripts = {name: page_bundle.facade(name, module) for name, module in modules.items()}
    scripts[page_bundle.ENTRY] = page_bundle.bundle(modules)
    joined = {name: (text.encode(), _TYPES[".js"]) for name, text in scripts.items()}
    joined[JOINED_STYLES] = (_joined_styles(), _TYPES[".css"])
    return joined


def _joined_styles() -> bytes:
    places = {"lib": libraries(), "page": own_files()}
    text = (PAGE / "index.html").read_text(encoding="utf-8")
    return b"\n".join(places[place][name].read_bytes() for place, name in STYLE_SHEET.findall(text))
