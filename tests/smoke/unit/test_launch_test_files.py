"""Files that `launch-test` cannot run, or that ask not to be run; nothing is launched here."""

from __future__ import annotations

import io
import unittest
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from launcher.base.errors import UsageError
from launcher.smoke.launch_tests import verb
from launcher.smoke.launch_tests.results import TestResult

DESCRIPTION = "\ndef generate_test_description(): pass\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(text: str, *words: str) -> int:
    Path("some_test.py").write_text(text)
    return verb._run(verb.COMMAND.parse(["some_test.py", *words]))


@pytest.mark.parametrize(
    "skip",
    [
        "import pytest\npytest.importorskip('not_there')",
        "import pytest\npytest.skip('not_there', allow_module_level=True)",
        "import unittest\nraise unittest.SkipTest('not_there')",
    ],
)
def test_a_file_that_skips_itself_is_skipped(capsys, skip: str):
    assert run(skip + DESCRIPTION, "--junit-xml", "report.xml", "--package-name", "some") == 0

    said = capsys.readouterr().out
    assert "some_test.py is skipped: " in said and "not_there" in said
    (suite,) = ET.parse("report.xml").getroot()
    assert (suite.attrib["tests"], suite.attrib["skipped"]) == ("1", "1")
    assert [(one.get("classname"), one.get("name")) for one in suite] == [("some", "some_test")]


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("import sys\nsys.exit(4)\n", 2, "sys.exit(4) ends the program"),
        ("raise SystemExit\n", 1, "sys.exit() ends the program"),
        ("\nimport not_there\n", 2, "ModuleNotFoundError: No module named 'not_there'"),
        ("\n\n(\n", 3, "SyntaxError: '(' was never closed"),
        ("import broken\n", 1, "SyntaxError: '(' was never closed (broken.py, line 2)"),
        ("def generate_test_description():\n    1 / 0\n", 2, "ZeroDivisionError"),
        ("def generate_test_description():\n    exit(3)\n", 2, "sys.exit(3) ends the program"),
    ],
)
def test_what_a_file_raises_is_an_error_with_its_line(
    folder: Path, monkeypatch, text: str, line: int, message: str
):
    Path("broken.py").write_text("\n(\n")
    monkeypatch.syspath_prepend(folder)

    with pytest.raises(UsageError) as refused:
        run(text)
    assert refused.value.where.endswith(f"some_test.py:{line}")
    assert refused.value.message.startswith(message)


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("n=3", "did you mean n:=3?"),
        ("n:=", None),
        ("some_test.py", "launch-test runs one file"),
    ],
)
def test_words_that_are_no_arguments_are_a_mistake_of_the_command_line(word: str, hint):
    with pytest.raises(UsageError, match=r"^malformed launch argument") as refused:
        run("raise AssertionError", word)
    assert (refused.value.where, refused.value.hint) == (None, hint)


def test_a_file_without_a_description_is_refused_with_a_hint():
    with pytest.raises(UsageError, match="has no function") as refused:
        run("x = 1")
    assert refused.value.hint is not None


class Skips(unittest.TestCase):
    __test__ = False

    def test_it(self):
        pytest.skip("not today")


def test_a_test_may_skip_itself_as_in_pytest():
    result = TestResult(unittest.runner._WritelnDecorator(io.StringIO()), False, 0)
    Skips("test_it").run(result)

    assert [reason for _, reason in result.skipped] == ["not today"]
    assert not result.errors
