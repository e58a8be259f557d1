"""Launch files on disk: detection of the format, and errors."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.errors import LaunchFileError
from launcher.language.description import LaunchDescription
from launcher.language.frontends.parser import Parser

XML = '<launch><log message="m"/></launch>'
YAML = "launch: [{log: {message: m}}]"


@pytest.mark.parametrize("name", ["a.xml", "a.yaml", "a.yml", "a.launch", "a"])
@pytest.mark.parametrize("text", [XML, YAML, f"\ufeff{XML}", f"\n# comment\n{YAML}"])
def test_every_suffix_loads_in_either_format(tmp_path: Path, name: str, text: str) -> None:
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    (log,) = load_markup(str(file)).entities
    assert type(log).__name__ == "LogInfo"


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.xml", b"<launch>\n<a", "a.xml:2: unclosed token"),
        ("a.yaml", b"launch:\n - [", "a.yaml:2: expected the node content"),
        ("a.foo", b"<launch>", "a.foo:1: no element found"),
        ("a.foo", b"launch: [", "a.foo:1: expected the node content"),
        ("a.xml", b"<launch>\n\xff</launch>", "/a.xml:2: the byte 0xff is not UTF-8"),
        ("a.yaml", b"launch:\n\n\xfe", "/a.yaml:3: the byte 0xfe is not UTF-8"),
        ("a.xml", b" \n", "/a.xml:1: the file is empty"),
        ("a.xml", b'<?xml version="1.0" encoding="nope"?><launch/>', "nope"),
        ("a.yaml", b"", "a.yaml:1: a YAML launch file is a mapping"),
        ("a.xml", b"<robot/>", "must be 'launch', not 'robot'"),
    ],
)
def test_broken_file_is_reported_with_its_line(
    tmp_path: Path, name: str, content: bytes, message: str
) -> None:
    file = tmp_path / name
    file.write_bytes(content)
    with pytest.raises(LaunchFileError) as caught:
        load_markup(str(file))
    assert message in caught.value.render().splitlines()[0]


def load_markup(path: str) -> LaunchDescription:
    entity, parser = Parser.load(path)
    return parser.parse_description(entity)


def test_without_a_known_suffix_the_errors_of_both_formats_are_reported(tmp_path: Path) -> None:
    file = tmp_path / "a.foo"
    file.write_text("launch: [")
    with pytest.raises(LaunchFileError) as caught:
        load_markup(str(file))
    assert caught.value.render().count("error: ") == 2


def test_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(LaunchFileError, match="cannot read"):
        load_markup(str(tmp_path / "nope.xml"))


def test_declared_encoding_counts_as_for_elementtree(tmp_path: Path) -> None:
    file = tmp_path / "a.xml"
    file.write_text(
        '<?xml version="1.0" encoding="latin-1"?><launch><log message="\u00fc"/></launch>',
        encoding="utf-8",
    )
    (log,) = load_markup(str(file)).entities
    assert log.msg[0].text == "\u00c3\u00bc"
