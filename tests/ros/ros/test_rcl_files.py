"""What the launcher knows about parameter files, compared with rcl."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from typing import Any

import pytest
import yaml

from launcher.base.model.parameter_sections import sections
from launcher.base.model.parameter_text import word_value
from launcher.ros.parameter_values import plain_value, typed_parameter
from tests.base.unit.test_parameter_text import WORDS
from tests.support.repository import REPOSITORY
from tests.support.ros_domain import ros_domain


@pytest.fixture(scope="module")
def env(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path_factory.mktemp("log")) as env:
        yield env


def read(env: dict[str, str], questions: Sequence[Sequence[str]]) -> list[Any]:
    done = subprocess.run(
        [sys.executable, "-m", "tests.support.rcl_reader"],
        input=json.dumps(questions),
        env=env,
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    answers: list[Any] = json.loads(done.stdout.splitlines()[-1])
    return answers


KEYS = (
    *("n", "/n", "a/b/n", "/a/b/n", "/a/n", "/A/b/n", "**", "/**", "*", "/*", "/*/n", "**/n"),
    *("/**/n", "/*/*/n", "/a/*", "/a/**", "/a/*/n", "/a/**/n", "/**/b/n", "/**/**", "/*/*/*"),
    *("/a/b/*", "/a/b/**", "/a/b/n/**", "/n/**"),
)
LEVELS = (
    *(("a", "b", "n"), ("/a", "b", "n"), ("/a/b", "n"), ("a/b", "n"), ("a/b/", "n"), ("/", "n")),
    *(("/**", "n"), ("a", "*", "n"), ("a", "**", "n"), ("/**", "*", "n"), ("x", "n")),
)
NODES = (("/", "n"), ("/a", "n"), ("/a/b", "n"))


def file_of(keys: Sequence[str]) -> str:
    tree: Any = {"ros__parameters": {"p": 1}}
    for key in reversed(keys):
        tree = {key: tree}
    return yaml.safe_dump(tree)


def test_a_section_is_for_the_nodes_that_rcl_gives_it_to(env: dict[str, str]):
    files = [file_of(keys) for keys in (*((key,) for key in KEYS), *LEVELS)]
    questions = [(text, *node) for text in files for node in NODES]
    for (text, namespace, name), answer in zip(questions, read(env, questions), strict=True):
        (section,) = sections(yaml.safe_load(text))
        is_for = section.is_for(f"{namespace.rstrip('/')}/{name}")
        assert answer == ({"p": 1} if is_for else {}), (text, namespace, name)


def test_words_are_what_rcl_takes_them_for(env: dict[str, str]):
    questions = [(f"/**:\n  ros__parameters:\n    p: {word}\n", "/", "n") for word in WORDS]
    for word, answer in zip(WORDS, read(env, questions), strict=True):
        expected = word_value(word)
        assert repr(answer["p"]) == repr(expected), word


VALUES = (
    *(
        "[1e-9, 0.0]",
        "[.5, 1e0]",
        "[0x10, 010]",
        "[yes, Off]",
        "[~, a]",
        "[0.0, -.inf]",
        "[-1, +2]",
    ),
    *("'1e-9'", '"5"', "!!str 5", "[!!str 1, !!str 2]", "!!int a", "!!float 5", "!!bool yes"),
    *("!!null a", "|-\n      5", ">-\n      1e-9"),
)


def test_values_on_the_command_line_are_what_rcl_takes_them_for(env: dict[str, str]):
    questions = [(f"/**:\n  ros__parameters:\n    p: {one}\n", "/", "n") for one in VALUES]
    for value, answer in zip(VALUES, read(env, questions), strict=True):
        found = plain_value(typed_parameter("p", value).value)
        assert repr(found) == repr(answer["p"]), value
