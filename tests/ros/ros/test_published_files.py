"""`topic pub --yaml-file`: the documents of a file, one after another."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from tests.support.verbs import going_on
from tests.support.waiting import rest_of

TEXTS = ("topic", "pub", "/files", "std_msgs/msg/String")
POINTS = ("topic", "pub", "/files", "geometry_msgs/msg/PointStamped")
NOW = ("-w", "0", "--keep-alive", "0", "-r", "100")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "messages.yaml"
    path.write_text("---\ndata: one\n---\n# none\n---\ndata: two\n---\ndata: three\n---\n")
    return path


def published(text: str) -> list[str]:
    return [line.partition("data=")[2] for line in text.splitlines() if "publishing #" in line]


def test_each_document_is_published_once(verb, file):
    answer = verb(*TEXTS, "--yaml-file", str(file), *NOW)
    assert published(answer.out) == ["'one')", "'two')", "'three')"]
    assert (answer.err, answer.code) == ("", 0)


@pytest.mark.thorough
@pytest.mark.parametrize(("times", "count"), [(["-1"], 1), (["-t", "2"], 2), (["-t", "9"], 3)])
def test_a_number_of_times_may_end_it_sooner(verb, file, times, count):
    answer = verb(*TEXTS, "--yaml-file", str(file), *NOW, *times)
    assert (len(published(answer.out)), answer.code) == (count, 0)


@pytest.mark.thorough
def test_what_echo_prints_is_published_again(verb, env, tmp_path):
    """Through a pipe without an end, and through a file."""
    path = tmp_path / "pipe"
    os.mkfifo(path)
    heard = verb("topic", "echo", "/points", "--once")
    with going_on(env, *POINTS, "--yaml-file", str(path), "-r", "100") as program:
        with path.open("w") as pipe:
            pipe.write(heard.out)
            pipe.flush()
            assert program.stdout is not None
            first = next(line for line in program.stdout if "publishing #1" in line)
            assert "frame_id='map'" in first
            pipe.write(heard.out)
        assert "publishing #2" in rest_of(program)[0]
    assert program.returncode == 0


@pytest.mark.thorough
def test_times_are_those_of_each_message(verb, tmp_path):
    path = tmp_path / "stamped.yaml"
    path.write_text("header: auto\npoint: {x: 1}\n---\nheader: {stamp: now, frame_id: map}\n")
    answer = verb(*POINTS, "--yaml-file", str(path), *NOW, "--json")
    first, second = (json.loads(line)["message"] for line in answer.lines)
    stamps = [
        (one["header"]["stamp"]["sec"], one["header"]["stamp"]["nanosec"])
        for one in (first, second)
    ]
    assert stamps[0] < stamps[1]
    assert stamps[0][0] > 1_700_000_000
    # each is a new message
    assert (first["point"]["x"], second["point"]["x"]) == (1.0, 0.0)
    assert (first["header"]["frame_id"], second["header"]["frame_id"]) == ("", "map")


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("data: a\n---\nnope: 1\n", "document 2: Failed to populate field: 'String' object has no"),
        ("data: a\n---\n- 1\n", "document 2: The passed value needs to be a dictionary in YAML"),
        ("data: a\n---\ndata: 'x\n", "document 2: The passed value is not YAML: "),
        ("# nothing\n---\n", "no message in it\n"),
        (None, "No such file or directory\n"),
    ],
    ids=["field", "list", "yaml", "empty", "absent"],
)
def test_nothing_is_published_of_a_file_with_a_mistake(verb, tmp_path, text, error):
    path = tmp_path / "messages.yaml"
    if text is not None:
        path.write_text(text)
    answer = verb(*TEXTS, "--yaml-file", str(path), *NOW)
    assert (answer.out, answer.code) == ("", 1)
    assert answer.err.startswith(str(path))
    assert error in answer.err


@pytest.mark.thorough
def test_ctrl_c_before_the_last_document_is_an_interruption(env, file):
    with going_on(env, *TEXTS, "--yaml-file", str(file), "-r", "0.001") as program:
        assert program.stdout is not None
        next(line for line in program.stdout if "publishing #1" in line)
    assert program.returncode == 130
