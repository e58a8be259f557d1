"""The page as one HTML file with the messages of runs, which opens from disk without a network.

Modules of the page become `blob:` URLs, which an import map gives their names. Everything is
compressed, and in base64: nothing of it can end the element that holds it.
"""

from __future__ import annotations

import base64
import gzip
import html
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from launcher.base import strict_json
from launcher.web import assets

_TEMPLATE = assets.PAGE / "frozen.html"
_PLACEHOLDER = re.compile(r"@([A-Z]+)@")
_URL_IN_CSS = re.compile(r"url\(/(lib|page)/([^)]+)\)")
_STATIC_IMPORT = re.compile(r'\b(from|import)(\s*)"\./([\w.-]+\.js)"')
_LAZY_IMPORT = re.compile(r'\bimport\("\./[\w.-]+\.js"\)')
_SOURCE_MAP = re.compile(r"^//# sourceMappingURL=.*$", re.MULTILINE)
# Loaded by an element `script`, not as a module.
_SCRIPTS = ("/lib/quasar.js",)
_POLICY = "; ".join(
    [
        "default-src 'none'",
        "script-src 'unsafe-inline' 'unsafe-eval' blob:",  # Vue compiles templates
        "worker-src blob:",
        "style-src 'unsafe-inline'",
        "font-src data:",
        "img-src data: blob:",
        "base-uri 'none'",
        "form-action 'none'",
    ]
)

Message = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class FrozenRun:
    """The messages of one run, `hello` first; `label` is for the choice of runs."""

    label: str
    messages: Sequence[Message]


def freeze(runs: Sequence[FrozenRun], *, title: str, chosen: int = 0) -> str:
    """The HTML file of at least one run; `chosen`: the index of the one that is shown first.

    Raises LauncherError if a file of the page is missing.
    """
    data = [
        f'<script type="text/plain" id="frozen-{i}">{_packed(_json(run.messages))}</script>'
        for i, run in enumerate(runs)
    ]
    labels = strict_json.dumps({"labels": [run.label for run in runs], "chosen": chosen})
    parts = {
        "POLICY": _POLICY,
        "TITLE": html.escape(title.encode(errors="replace").decode()),
        "FILES": _packed(strict_json.dumps(_files())),
        "RUNS": labels.replace("<", "\\u003c"),
        "DATA": "\n    ".join(data),
    }
    template = _TEMPLATE.read_text(encoding="utf-8")
    return _PLACEHOLDER.sub(lambda match: parts[match[1]], template)


def _packed(text: str) -> str:
    """Compressed, in base64; the same for the same text."""
    return base64.b64encode(gzip.compress(text.encode("ascii"), mtime=0)).decode()


def _json(messages: Sequence[Message]) -> str:
    return strict_json.dumps(messages, separators=(",", ":"), default=str)


# ---- the files of the page


def _files() -> dict[str, Any]:
    """`modules` by the names that imports use, `scripts` by their addresses, `styles` in order."""
    own = assets.own_files()
    libraries = assets.libraries()
    modules = {f"page/{name}": _text(path) for name, path in own.items() if path.suffix == ".js"}
    modules |= {"vue": _text(libraries["vue.js"]), **_chunks(libraries, "echarts/index.js")}
    modules["echarts"] = modules.pop("lib/echarts/index.js")
    index = (assets.PAGE / "index.html").read_text(encoding="utf-8")
    places = {"lib": libraries, "page": own}
    return {
        "modules": modules,
        "scripts": {name: _text(libraries[name.removeprefix("/lib/")]) for name in _SCRIPTS},
        "styles": [
            _with_urls(_text(places[place][name]), places)
            for place, name in assets.STYLE_SHEET.findall(index)
        ],
    }


def _text(path: Path) -> str:
    return _SOURCE_MAP.sub("", path.read_text(encoding="utf-8"))


def _chunks(libraries: Mapping[str, Path], entry: str) -> dict[str, str]:
    """A module and what it imports, under names that do not depend on where a module is.

    What it would load later (the 3D charts of ECharts) is left out.
    """
    folder = entry.rpartition("/")[0]
    found: dict[str, str] = {}
    waiting = [entry]
    while waiting:
        name = waiting.pop()
        if f"lib/{name}" in found:
            continue
        text = _text(libraries[name])
        waiting += [f"{folder}/{match[3]}" for match in _STATIC_IMPORT.finditer(text)]
        text = _STATIC_IMPORT.sub(rf'\1\2"lib/{folder}/\3"', text)
        found[f"lib/{name}"] = _LAZY_IMPORT.sub("Promise.reject(new Error('left out'))", text)
    return found


def _with_urls(css: str, places: Mapping[str, Mapping[str, Path]]) -> str:
    """With the fonts and pictures themselves in place of their addresses."""

    def embedded(match: re.Match[str]) -> str:
        data, kind = assets.content(places[match[1]][match[2]])
        return f"url(data:{kind};base64,{base64.b64encode(data).decode()})"

    return _URL_IN_CSS.sub(embedded, css)
