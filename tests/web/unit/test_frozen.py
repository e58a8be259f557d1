"""The page as one file: what is embedded, and that nothing of it can end its element."""

from __future__ import annotations

import base64
import functools
import gzip
import json
import math
import re
from collections.abc import Iterator
from typing import Any

import pytest

from launcher.web import assets
from launcher.web import frozen as frozen_page
from launcher.web.frozen import FrozenRun, freeze

HELLO = {"event": "hello", "run": {"target": "x.launch.py"}}


@pytest.fixture(scope="module", autouse=True)
def _files_are_packed_once() -> Iterator[None]:
    """Those of the page are the same in every document, and take a fifth of a second."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("_files", "_packed"):
            patch.setattr(frozen_page, name, functools.cache(getattr(frozen_page, name)))
        yield


def frozen(*messages: dict[str, Any], title: str = "report", label: str = "run") -> str:
    run = FrozenRun(label=label, messages=[HELLO, *messages])
    return freeze([run], title=title)


def element(text: str, name: str) -> str:
    found = re.search(rf'<script type="[a-z/]+" id="{name}">(.*?)</script>', text, re.DOTALL)
    assert found is not None, name
    return found[1]


def unpacked(text: str, name: str) -> Any:
    return json.loads(gzip.decompress(base64.b64decode(element(text, name))))


def test_the_messages_come_back():
    lines = {
        "event": "lines",
        "first": 1,
        "lines": [["a-1", "stdout", 1.5, "INFO", "ä \u2028 </x>"]],
    }
    assert unpacked(frozen(lines), "frozen-0") == [HELLO, lines]


def test_what_is_no_json_becomes_null_and_what_is_no_text_a_replacement():
    odd = {"event": "history", "values": [math.nan, math.inf, 1.0], "text": "\udcff"}
    _, found = unpacked(frozen(odd), "frozen-0")
    assert found == {"event": "history", "values": [None, None, 1.0], "text": "\ufffd"}


def test_no_text_ends_an_element():
    hostile = "</script><script>alert(1)</script><!--"
    lines = {"event": "lines", "first": 1, "lines": [["a", "stdout", 1.0, "INFO", hostile]]}
    clean, text = frozen(), frozen(lines, title=hostile, label=hostile)
    assert text.count("<script") == clean.count("<script")
    assert text.count("</script") == clean.count("</script")
    assert json.loads(element(text, "frozen-runs"))["labels"] == [hostile]
    assert "<title>&lt;/script&gt;" in text


def test_a_text_like_a_placeholder_stays():
    assert "<title>@DATA@</title>" in frozen(title="@DATA@")


def test_every_module_and_whatever_it_imports_is_there():
    modules = unpacked(frozen(), "frozen-files")["modules"]
    own = {f"page/{name}" for name in assets.own_files() if name.endswith(".js")}
    assert modules.keys() >= own | {"vue", "echarts"}
    named = re.compile(r"""(?:\bfrom|\bimport)\s*\(?\s*["']([\w./@-]+)["']""")
    for name, text in modules.items():
        if name.startswith("page/") or name == "echarts":
            assert set(named.findall(text)) <= modules.keys(), name


def test_nothing_has_an_address_elsewhere():
    files = unpacked(frozen(), "frozen-files")
    for style in files["styles"]:
        assert not re.search(r"url\((?![\"']?data:)", style)
        assert "@import" not in style
    assert any("url(data:font/woff2;base64," in style for style in files["styles"])
    assert not any("sourceMappingURL" in text for text in files["modules"].values())


def test_the_file_is_the_same_for_the_same_messages(monkeypatch: pytest.MonkeyPatch):
    for name in ("_files", "_packed"):  # made twice
        monkeypatch.setattr(frozen_page, name, getattr(frozen_page, name).__wrapped__)

    assert frozen() == frozen()


def test_the_server_does_not_serve_the_template():
    assert not [name for name in assets.own_files() if name.endswith(".html")]
