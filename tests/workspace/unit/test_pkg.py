"""`pkg list|prefix|executables|xml` against folders as pip and colcon make them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.verbs import in_process

MANIFEST = """\
<?xml version="1.0"?>
<package format="3">
  <name>fine</name>
  <version>1.2.3</version>
  <depend>rclpy</depend>
  <depend>std_msgs</depend>
</package>
"""


@pytest.fixture
def prefix(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A prefix with the package `fine`, which has two programs, and `bare`, which has nothing."""
    prefix = tmp_path / "prefix"
    index = prefix / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True)
    for name in ("fine", "bare"):
        (index / name).touch()
        (prefix / "share" / name).mkdir()
    (prefix / "share/fine/package.xml").write_text(MANIFEST, encoding="utf-8")
    programs = prefix / "lib/fine"
    programs.mkdir(parents=True)
    for name in ("talker", "listener", "notes.txt"):
        (programs / name).touch(0o644 if name.endswith(".txt") else 0o755)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(prefix))
    monkeypatch.chdir(tmp_path)
    return prefix


def test_list_has_all_packages_sorted(prefix):
    lines = in_process("pkg", "list").lines
    assert lines == sorted(lines)
    assert {"bare", "fine", "std_msgs"} <= {*lines}


def test_prefix_and_share_of_a_package(prefix):
    assert in_process("pkg", "prefix", "fine").out == f"{prefix}\n"
    assert in_process("pkg", "prefix", "--share", "fine").out == f"{prefix}/share/fine\n"


def test_executables_of_one_package_and_of_all(prefix):
    assert in_process("pkg", "executables", "fine").lines == ["fine listener", "fine talker"]
    assert in_process("pkg", "executables", "fine", "--full-path").lines == [
        f"{prefix}/lib/fine/listener",
        f"{prefix}/lib/fine/talker",
    ]
    assert in_process("pkg", "executables", "bare").lines == []
    assert {"fine listener", "fine talker"} <= {*in_process("pkg", "executables").lines}


def test_the_manifest_and_its_tags(prefix):
    assert in_process("pkg", "xml", "fine").out == MANIFEST
    assert in_process("pkg", "xml", "fine", "--tag", "version").out == "1.2.3\n"
    assert in_process("pkg", "xml", "fine", "-t", "depend").lines == ["rclpy", "std_msgs"]


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["prefix", "fin"], "Package not found\nhint: did you mean 'fine'?\n"),
        (["executables", "fin"], "Package 'fin' not found\nhint: did you mean 'fine'?\n"),
        (["xml", "fin"], "Package not found\nhint: did you mean 'fine'?\n"),
        (["xml", "bare"], "Package 'bare' has no package.xml: "),
        (
            ["xml", "fine", "-t", "licence"],
            "XML tag 'licence' not found\nhint: tags: name, version, depend\n",
        ),
        (["xml", "fine", "-t", "*"], "XML tag '*' not found\n"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_what_is_not_there_is_named(prefix, words, error):
    answer = in_process("pkg", *words)
    assert (answer.out, answer.code, answer.err.startswith(error)) == ("", 1, True), answer


def test_a_manifest_that_is_not_xml_is_named(prefix):
    path = prefix / "share/fine/package.xml"
    path.write_text("<package>", encoding="utf-8")
    answer = in_process("pkg", "xml", "fine")
    assert (answer.code, answer.err.startswith(f"{path}: ")) == (1, True), answer


@pytest.mark.parametrize(
    "words", [["list", "x"], ["prefix"], ["xml"], ["executables", "a", "b"], ["list", "--json"]]
)
def test_wrong_words(words):
    assert in_process("pkg", *words).code == 2


@pytest.mark.parametrize("verb", ["status", "start", "stop"])
def test_there_is_no_daemon(verb):
    answer = in_process("daemon", verb)
    assert (answer.code, answer.err) == (0, "")
    assert (
        answer.out == "There is no daemon, and none is needed: every verb reads the graph itself\n"
    )


def test_wtf_is_doctor():
    assert in_process("wtf", "--help").out == in_process("doctor", "--help").out
    assert in_process("help", "wtf").out == in_process("doctor", "--help").out
