"""What is printed where the encoding of the output lacks characters."""

from __future__ import annotations

import io
import json
import sys

import pytest

from launcher.__main__ import print_all_characters
from launcher.posix.json_output import print_document, print_line
from launcher.posix.stdio import can_print

TREE = "├── a │ b\n└── 1 Hz ± 20 % cut…"


def output(monkeypatch: pytest.MonkeyPatch, encoding: str, errors: str = "strict") -> io.BytesIO:
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding=encoding, errors=errors, write_through=True)
    monkeypatch.setattr(sys, "stdout", stream)
    print_all_characters()
    return raw


@pytest.mark.parametrize(
    ("encoding", "text", "shown"),
    [
        ("ascii", TREE, b"|-- a | b\n`-- 1 Hz +- 20 % cut~"),
        ("latin-1", TREE, b"|-- a | b\n`-- 1 Hz \xb1 20 % cut~"),
        ("ascii", "größe 🤖", rb"gr\u00f6\u00dfe \ud83e\udd16"),
        ("latin-1", "größe 🤖", b"gr\xf6\xdfe \\ud83e\\udd16"),
        ("utf-8", "größe 🤖", "größe 🤖".encode()),
        ("ascii", "file \udcff\udcfe", b"file \xff\xfe"),
        ("utf-8", "file \udcff\udcfe", b"file \xff\xfe"),
        ("utf-8", "half \ud83e", rb"half \ud83e"),
    ],
)
@pytest.mark.parametrize("errors", ["strict", "surrogateescape"])
def test_every_text_can_be_printed(monkeypatch, encoding, errors, text, shown):
    raw = output(monkeypatch, encoding, errors)
    print(text, end="")
    assert raw.getvalue() == shown


def test_what_the_user_has_chosen_for_such_characters_applies(monkeypatch):
    raw = output(monkeypatch, "ascii", "replace")  # PYTHONIOENCODING=ascii:replace
    print("größe ─", end="")
    assert raw.getvalue() == b"gr??e ?"


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_json_keeps_its_values(monkeypatch, encoding):
    for form in (print_document, print_line):
        raw = output(monkeypatch, encoding)
        form({"texts": [TREE, "größe 🤖"]})
        assert json.loads(raw.getvalue()) == {"version": 1, "texts": [TREE, "größe 🤖"]}


def test_a_form_may_have_a_version_of_its_own(capsys):
    print_line({"version": 3, "a": {"b": [1]}})
    assert capsys.readouterr().out == '{"version": 3, "a": {"b": [1]}}\n'


def test_whether_an_encoding_has_characters(monkeypatch):
    output(monkeypatch, "latin-1")
    assert can_print("größe")
    assert not can_print("─")
