"""Annotations and summaries of GitHub Actions."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.base.github import add_summary, annotation, is_on, plain, table


@pytest.mark.parametrize(("value", "on"), [("true", True), ("false", False), ("", False)])
def test_it_is_on_where_a_workflow_says_so(value: str, on: bool):
    assert is_on({"GITHUB_ACTIONS": value}) is on
    assert not is_on({})


def test_an_annotation_escapes_what_would_end_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("GITHUB_WORKSPACE", raising=False)
    made = annotation("a: 5 %,\nb", title="x: y, z", place=f"{tmp_path}/a/b.yaml:3")
    assert made == "::error file=a/b.yaml,line=3,title=x%3A y%2C z::a: 5 %25,%0Ab"
    assert annotation("m", title="t") == "::error title=t::m"


def test_a_place_is_relative_to_the_repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "src").mkdir()
    monkeypatch.chdir(tmp_path / "src")
    monkeypatch.setenv("GITHUB_WORKSPACE", str(tmp_path))
    assert "file=src/a.py,line=1," in annotation("m", title="t", place="a.py:1")
    outside = os.path.dirname(tmp_path)
    assert f"file={outside}/a.py," in annotation("m", title="t", place=f"{outside}/a.py:1")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("12 of 12 met, 5.0 s", "12 of 12 met, 5.0 s"),
        ("a | b\n# c", "a &#124; b &#35; c"),
        ("<b>*&_", "&#60;b&#62;&#42;&#38;&#95;"),
        ("@me [x](y) \x1b[1m", "&#64;me &#91;x&#93;(y) &#92;x1b&#91;1m"),
        ("x" * 400, "x" * 300 + "..."),
    ],
)
def test_a_text_is_shown_as_it_is(text: str, shown: str):
    assert plain(text) == shown


def test_a_table_has_a_row_for_each_line():
    assert table(("", "a"), [("1", "|"), ("2", "b")]) == [
        "|  | a |",
        "| --- | --- |",
        "| 1 | &#124; |",
        "| 2 | b |",
    ]


def test_a_summary_is_appended(tmp_path: Path):
    path = tmp_path / "summary.md"
    path.write_text("# before\n")
    env = {"GITHUB_STEP_SUMMARY": str(path)}
    assert add_summary(env, ["### a", "", "b \udcff"]) is None
    assert add_summary(env, ["### c"]) is None
    assert path.read_text() == "# before\n### a\n\nb \\udcff\n\n### c\n\n"


def test_a_summary_that_cannot_be_written_is_said(tmp_path: Path):
    problem = add_summary({"GITHUB_STEP_SUMMARY": str(tmp_path)}, ["a"])
    assert problem == f"cannot write GITHUB_STEP_SUMMARY {tmp_path}: Is a directory"
    assert add_summary({}, ["a"]) is None
