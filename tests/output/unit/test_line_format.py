"""Lines of the screen in compact form or by a template."""

from __future__ import annotations

import time

import pytest

from launcher.base.model.spec import ProcessSpec
from launcher.output import line_format
from launcher.output.line_format import LineFormat
from launcher.run.output.stream import Stream

AT = 1763852000.123456
CLOCK = time.strftime("%H:%M:%S", time.localtime(AT)).encode() + b".123"
DATE = time.strftime("%Y-%m-%d", time.localtime(AT)).encode()
ONE, TWO = b"[robot_1-1] ", b"[dispatcher-2] "
LINE = b"[INFO] [1763852000.123456] [%b]: text\n"


def form(name: str = "compact", *, colour: bool = False, env: dict[str, str] | None = None):
    specs = [
        ProcessSpec(name=f"{label}-{number}", label=label, argv=("a",), env=env or {})
        for number, label in ((1, "robot_1"), (2, "dispatcher"))
    ]
    colours = (b"\x1b[38;5;39m", b"\x1b[38;5;208m") if colour else (b"", b"")
    sources = {f"[{s.name}] ".encode(): (s, c) for s, c in zip(specs, colours, strict=True)}
    return LineFormat(name, sources, colour=colour)


@pytest.mark.parametrize(
    ("logger", "before"),
    [
        (b"robot_1", b""),
        (b"fleet.robot_1", b""),
        (b"robot_1.nav", b"robot_1.nav: "),
        (b"camera", b"camera: "),
    ],
)
def test_a_compact_line_has_the_time_and_the_name_once(logger: bytes, before: bytes):
    shown = form().lines(ONE, "s", LINE % logger)
    assert shown == CLOCK + b" I robot_1    " + before + b"text\n"


def test_a_line_of_a_node_with_80_columns_of_text_fits_120_columns():
    text = b"x" * 80
    line = b"[WARN] [1763852000.123456789] [fleet.dispatcher]: " + text + b"\n"
    shown = form().lines(TWO, "s", line)
    assert shown == CLOCK + b" W dispatcher " + text + b"\n"
    assert len(TWO + line) > 120 >= len(shown)


def test_the_level_is_a_colour_or_a_letter():
    compact = form(colour=True)
    line = b"\x1b[31m[ERROR] [1763852000.123456] [robot_1]: text\x1b[0m\n"
    name = b"\x1b[38;5;39mrobot_1\x1b[0m    "
    assert compact.lines(ONE, "s", line) == CLOCK + b" " + name + b"\x1b[31mtext\x1b[0m\n"
    plain = LINE % b"robot_1"
    assert compact.lines(ONE, "s", plain) == CLOCK + b" " + name + b"text\n"
    letters = [
        form().lines(ONE, "s", plain.replace(b"INFO", level))[13:15]
        for level in (b"DEBUG", b"INFO", b"WARN", b"ERROR", b"FATAL")
    ]
    assert letters == [b"D ", b"I ", b"W ", b"E ", b"F "]


def test_lines_that_continue_a_message_are_aligned_with_it():
    lines = (LINE % b"robot_1") + b"second\n  third\n"
    blanks = b" " * len(CLOCK + b" I robot_1    ")
    first, *others = form().lines(ONE, "s", lines).split(b"\n")
    assert first.endswith(b" text")
    assert others == [blanks + b"second", blanks + b"  third", b""]


def test_a_traceback_is_one_message_whatever_block_it_is_read_in():
    compact = form()
    lines = b"Traceback (most recent call last):\n  File 'x'\nValueError: 3\nafter\n".splitlines(
        True
    )
    shown = [compact.lines(ONE, "s", line) for line in lines]
    blanks = b" " * len(CLOCK + b" I robot_1    ")
    assert b" E robot_1    Traceback" in shown[0]
    assert shown[1:3] == [blanks + b"  File 'x'\n", blanks + b"ValueError: 3\n"]
    assert shown[3].endswith(b" I robot_1    after\n") and shown[3] != blanks + b"after\n"


def test_a_line_that_continues_another_process_has_its_own_name():
    compact = form()
    compact.lines(ONE, "s", b"first\n")
    compact.lines(TWO, "t", b"between\n")
    assert compact.lines(ONE, "s", b"  more\n").endswith(b" I robot_1      more\n")
    compact.own("INFO", "launch", b"of the launcher\n")
    assert compact.lines(ONE, "s", b"  more\n").endswith(b" I robot_1      more\n")
    assert compact.lines(ONE, "s", b"  more\n") == b" " * 26 + b"  more\n"


def test_the_launchers_lines_have_the_same_columns():
    compact = form()
    compact.lines(ONE, "s", b"a\n")
    assert compact.own("INFO", "robot_1-1", b"process started\n")[13:] == (
        b"I robot_1    process started\n"
    )
    assert compact.own("WARNING", "launch", b"a\n    b\n")[13:] == b"W launch     a\n    b\n"
    assert compact.own("CRITICAL", "launch", b"a\n")[13:] == b"F launch     a\n"


@pytest.mark.parametrize(
    ("node_format", "line"),
    [
        ("{severity}|{name}|{message}", b"WARN|robot_1|text"),
        ("[{time_as_nanoseconds}] {severity}: {message}", b"[1763852000123456789] WARN: text"),
        ("{message} ({severity} {file_name}:{line_number})", b"text (WARN a.py:3)"),
        ("{severity} {severity} {unknown} {message}", b"WARN WARN {unknown} text"),
    ],
)
def test_the_format_that_a_node_has_already_is_understood(node_format: str, line: bytes):
    compact = form(env={"RCUTILS_CONSOLE_OUTPUT_FORMAT": node_format})
    assert compact.lines(ONE, "s", line + b"\n").endswith(b" W robot_1    text\n")


@pytest.mark.parametrize("node_format", ["{message}", "{name}: {message}"])
def test_a_node_format_without_a_level_leaves_the_line_as_it_is(node_format: str):
    compact = form(env={"RCUTILS_CONSOLE_OUTPUT_FORMAT": node_format})
    assert compact.lines(ONE, "s", b"a: b\n").endswith(b" I robot_1    a: b\n")


@pytest.mark.parametrize(
    ("template", "shown"),
    [
        ("[{severity}] [{name}]: {message}", b"[INFO] [camera]: text"),
        ("{process} {time} {message}.", b"robot_1-1 1763852000.123456000 text."),
        ("{date_time_with_ms} {message}", DATE + b" " + CLOCK + b" text"),
        ("{clock}|{message}", CLOCK + b"|text"),
        ("{time_as_nanoseconds} {message}", b"1763852000123456000 text"),
    ],
)
def test_a_template_has_the_tokens_of_rcutils_and_more(template: str, shown: bytes):
    line = form(template).lines(ONE, "s", LINE % b"camera")
    assert line == shown + b"\n"


def test_a_line_without_a_head_has_the_name_of_its_process_in_a_template():
    shown = form("{severity} {name}: {message}").lines(ONE, "s", b"WARNING: hot\n  very\n")
    assert shown == b"WARN robot_1: WARNING: hot\n" + b" " * 14 + b"  very\n"


def test_a_line_that_another_host_read_a_while_ago_has_its_own_time():
    stream = Stream("stdout", shown=True)
    stream.ago_s = time.time() - AT
    shown = form("{time} {message}").lines(ONE, stream, b"late\n")
    assert shown[-6:] == b" late\n"
    assert abs(float(shown.split()[0]) - AT) < 60


@pytest.mark.parametrize(
    ("word", "problem"),
    [
        ("compcat", "did you mean 'compact'?"),
        ("bogus", "unknown format 'bogus'; default, compact, or a text with {message}"),
        ("{severity}", "a format is one line with {message}"),
        ("{message} {line_number}", "set RCUTILS_CONSOLE_OUTPUT_FORMAT"),
        ("{mesage}", "unknown token {mesage}"),
        ("{time:.3f} {message}", "'{time:.3f}' in a format: tokens take no options; try {time}"),
        ("{message!r}", "'{message!r}' in a format: tokens take no options; try {message}"),
        ("{name } {message}", "'{name }' in a format"),
        ("{message", "'{message' in a format lacks its '}'; write {message}"),
        ("{severity {message}", "'{severity' in a format lacks its '}'; write {severity}"),
        ("a\n{message}", "one line"),
    ],
)
def test_a_wrong_format_is_told(word: str, problem: str):
    with pytest.raises(ValueError) as raised:
        line_format.check(word)
    assert problem in str(raised.value)


def test_a_time_that_is_none_does_no_harm():
    shown = form().lines(ONE, "s", b"[INFO] [%b.0] [robot_1]: text\n" % (b"9" * 18))
    assert shown.endswith(b" I robot_1    text\n")
