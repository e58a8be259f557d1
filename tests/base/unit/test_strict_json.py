"""JSON of any text and number, and of nothing else."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.base import strict_json
from tests.support.repository import REPOSITORY

ROOT = REPOSITORY / "launcher"
# Programs that run where the package is not: they are sent to hosts as their source.
ALONE = ("hosts/check/probe.py", "hosts/sync/on_host/", "hosts/engine/systemd/scripts.py")
IMPORT = re.compile(r"^ *(import|from) +json\b", re.MULTILINE)


def _values(texts: st.SearchStrategy[str]) -> st.SearchStrategy[object]:
    return st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | texts,
        lambda inner: st.lists(inner) | st.dictionaries(texts, inner),
        max_leaves=20,
    )


VALUES = _values(st.text(st.characters(codec=None) | st.sampled_from('\\u"d8\udcff\ud83d\ude00')))
# Of the surrogates only those that stand for bytes.
NAMES = st.text(st.characters(codec="utf-8") | st.sampled_from('\\u"\udc80\udcff'))


@given(VALUES, st.booleans())
def test_whatever_is_written_is_unicode_and_standard_json(value: object, is_ascii: bool):
    text = strict_json.dumps(value, ensure_ascii=is_ascii)
    found = strict_json.loads(text.encode())
    json.dumps(found, ensure_ascii=False).encode()


@given(st.recursive(st.integers() | st.text(), st.lists))
def test_valid_texts_and_numbers_are_kept(value: object):
    assert strict_json.loads(strict_json.dumps(value)) == value
    assert strict_json.loads(strict_json.dumps(value, ensure_ascii=False)) == value


@pytest.mark.parametrize("is_ascii", [True, False])
def test_what_is_no_character_is_replaced_and_nothing_beside_it(is_ascii: bool):
    text = 'a\udcff\\udcff\\\udcff\U0001f600"\n\ud83d'
    shown = strict_json.dumps([text], ensure_ascii=is_ascii)
    assert shown.isascii() == is_ascii
    assert json.loads(shown) == ['a\ufffd\\udcff\\\ufffd\U0001f600"\n\ufffd']


def test_numbers_that_json_does_not_have_are_null_or_what_the_caller_says():
    value = {"a": (math.nan, 1.5), "b": Path("/x")}
    assert strict_json.dumps(value, default=str) == '{"a": [null, 1.5], "b": "/x"}'
    assert strict_json.dumps([math.inf, -math.inf], not_finite=str) == '["inf", "-inf"]'


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        b"\xff",
        "NaN",
        "-Infinity",
        "1e999",
        "[-1e+0999]",
        "1" * 400,
        "1" * 5000,
        "1" * 400 + ".5",
        "[" * 100_000,
        "[" * 100_000 + "]" * 100_000,
        '{"a":' * 100_000,
        "[" * 300 + "]" * 300,
    ],
    ids=lambda text: repr(text)[:12] + str(len(text)),
)
def test_everything_that_cannot_be_used_is_a_value_error(text: str | bytes):
    with pytest.raises(ValueError):
        strict_json.loads(text)


def test_as_deep_and_as_large_as_allowed_is_read():
    depth = strict_json.MAX_DEPTH
    strict_json.loads("[" * depth + "]" * depth)
    with pytest.raises(ValueError, match="deep"):
        strict_json.loads("[" * (depth + 1) + "]" * (depth + 1))
    assert strict_json.loads(f'["{"[" * 1000}", 1e300, {2**64}]')[1:] == [1e300, 2**64]
    assert strict_json.loads(f'{{"digits": "{"1" * 5000}"}}') == {"digits": "1" * 5000}


@given(_values(NAMES))
def test_a_message_between_our_processes_arrives_as_it_was(value: object):
    sent = strict_json.packed(value)
    assert sent.isascii()
    assert repr(strict_json.unpacked(sent.encode())) == repr(value)


def test_a_message_between_our_processes_is_not_deep_either():
    with pytest.raises(ValueError, match="deep"):
        strict_json.unpacked(b"[" * 100_000)


def test_no_other_module_writes_or_reads_json():
    others = [
        str(path.relative_to(ROOT))
        for path in sorted(ROOT.rglob("*.py"))
        if path.name != "strict_json.py" and not str(path.relative_to(ROOT)).startswith(ALONE)
        if IMPORT.search(path.read_text(encoding="utf-8"))
    ]
    assert others == []
