"""From bytes to prefixed lines: nothing is lost or split, and no escape sequence gets through."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.output import lines
from launcher.output.escapes import whole_characters
from launcher.output.lines import (
    CUT_MARK,
    LINE_LIMIT,
    LineBuffer,
    for_pipe,
    for_terminal,
    with_prefix,
)


def feed_all(chunks: list[bytes]) -> bytes:
    buffer = LineBuffer()
    out = b"".join(buffer.feed(chunk)[0] for chunk in chunks)
    return out + buffer.take_partial()[0]


def test_a_line_that_comes_in_two_parts_is_one_line():
    assert feed_all([b"par", b"tial\nnext", b"\n"]) == b"partial\nnext\n"


def test_the_last_line_without_a_newline_gets_one():
    assert feed_all([b"a\nb"]) == b"a\nb\n"


@given(st.lists(st.binary(max_size=30), max_size=20))
def test_however_it_is_cut_into_reads_the_bytes_come_out(chunks):
    whole = b"".join(chunks)
    expected = whole if whole.endswith(b"\n") or not whole else whole + b"\n"
    assert feed_all(chunks) == expected


def test_a_line_of_the_limit_is_whole():
    line = b"x" * LINE_LIMIT + b"\n"
    assert feed_all([line[:1000], line[1000:]]) == line


@pytest.mark.parametrize("size", [7, 4096, 10 * LINE_LIMIT])
def test_a_longer_line_is_cut_visibly_and_the_next_one_is_whole(size):
    data = b"x" * (3 * LINE_LIMIT) + b"\nnext\n"
    chunks = [data[i : i + size] for i in range(0, len(data), size)]
    assert feed_all(chunks) == b"x" * LINE_LIMIT + CUT_MARK + b"\nnext\n"


def test_a_long_block_of_short_lines_is_not_looked_at_line_by_line(monkeypatch):
    monkeypatch.setattr(lines, "_cut", None)
    block = b"a short line\n" * (LINE_LIMIT // 5)
    assert feed_all([block]) == block


def test_a_long_line_within_a_block_of_others_is_cut():
    short = b"a short line\n" * (LINE_LIMIT // 10)
    for size in (LINE_LIMIT + 1000, 3 * LINE_LIMIT):
        found = feed_all([short + b"x" * size + b"\n" + short])
        assert found == short + b"x" * LINE_LIMIT + CUT_MARK + b"\n" + short


def test_screen_and_log_file_share_a_block_with_the_same_prefix():
    block = b"one\ntwo\n"
    first = with_prefix(b"[a] ", block)
    assert first == b"[a] one\n[a] two\n"
    assert with_prefix(b"[a] ", block) is first
    assert with_prefix(b"[b] ", block) == b"[b] one\n[b] two\n"
    assert with_prefix(b"[a] ", b"three\n") == b"[a] three\n"


def test_an_endless_line_does_not_grow_in_memory():
    buffer = LineBuffer()
    for _ in range(100):
        buffer.feed(b"x" * LINE_LIMIT)
    assert len(buffer.partial) <= LINE_LIMIT + len(CUT_MARK)


def test_a_line_tells_how_much_of_it_was_shown():
    buffer = LineBuffer()
    buffer.feed(b"name? ")
    buffer.shown = 6
    assert buffer.feed(b"bob\nmore\n") == (b"name? bob\nmore\n", 6)
    assert buffer.feed(b"x\n") == (b"x\n", 0)


@pytest.mark.parametrize(
    ("written", "shown"),
    [
        (b"plain\n", b"plain\n"),
        (b"\x1b[31mred\x1b[0m\n", b"\x1b[31mred\x1b[0m\n"),
        (b"\x1b[1;38;5;208mx\x1b[m\n", b"\x1b[1;38;5;208mx\x1b[m\n"),
        (b"a\x1b[2Kb\x1b[10;3Hc\n", b"abc\n"),
        (b"\x1b]0;title\x07text\n", b"text\n"),
        (b"\x1b]8;;http://x\x1b\\link\x1b]8;;\x1b\\\n", b"link\n"),
        (b"\x1bcreset\n", b"reset\n"),
        (b"\x1b[?25lhidden cursor\n", b"hidden cursor\n"),
        (b"\x1b[31mleft open\n", b"\x1b[31mleft open\x1b[0m\n"),
        (b"half\x1b[2\n", b"half\n"),
        (b"half\x1b]0;title\nnext\n", b"half\nnext\n"),
        (b"lone\x1b\n", b"lone\n"),
        (b"one \xc2\x9b2J character\n", b"one 2J character\n"),
        ("caf\u00e9 \u00a0\n".encode(), "caf\u00e9 \u00a0\n".encode()),
        (b"next\xc2\x85line \xc2\x84 index\n", b"next\xc2\x85line \xc2\x84 index\n"),
        (b"shift\x0eout\x08 \x0b\x0c\x1c\x07\x7f\n", b"shift\x0eout\x08 \x0b\x0c\x1c\x07\x7f\n"),
        (b"crlf\r\n", b"crlf\r\n"),
        (b"\x1b[31mred\r\n", b"\x1b[31mred\x1b[0m\r\n"),
        (b"10%\r20%\r30%\n", b"10%\r20%\r30%\n"),
        (b"nul\0 bad \xff\xfe\n", b"nul\0 bad \xff\xfe\n"),
        ("größe \u2028 \u2029\n".encode(), "größe \u2028 \u2029\n".encode()),
    ],
)
def test_of_escape_sequences_only_colours_reach_a_pipe_and_all_other_bytes(written, shown):
    assert for_pipe(written) == shown


@pytest.mark.parametrize(
    ("written", "shown"),
    [
        (b"bell\x07 who\x05 xon\x11\x12 xoff\x13\x14\n", b"bell who xon xoff\n"),
        (b"can\x18cel sub\x1a del\x7f\n", b"cancel sub del\n"),
        (b"nul\0 tab\t bad \xff\xfe\n", b"nul\0 tab\t bad \xff\xfe\n"),
        (b"shift\x0eout\x08 \x0b\x0c\n", b"shiftout \n"),
        (b"next\xc2\x85line \xc2\x9b2J\n", b"nextline 2J\n"),
        (b"crlf\r\n", b"crlf\n"),
        (b"10%\r20%\r30%\n", b"30%\n"),
        (b"\x1b[31m10%\r20%\r\n", b"20%\n"),
        (b"10%\r\x1b[31m20%\r\n", b"\x1b[31m20%\x1b[0m\n"),
        (b"csi \x9b2J osc \x9d0;t\x9c\n", b"csi 2J osc 0;t\n"),
        (b"in \xe2\x82\xac and out \x9b\n", b"in \xe2\x82\xac and out \n"),
        (b"put together \xc2\xc2\x9b\x9b2J\n", b"put together 2J\n"),
        (b"put together \xc2\x07\x9b2J\n", b"put together \xc22J\n"),
        (b"put together \x1b\x07[2J\n", b"put together [2J\n"),
        ("größe € \u00a0\n".encode(), "größe € \u00a0\n".encode()),
        (b"\x1b[5mblinks\x1b[0m\n", b"blinks\x1b[0m\n"),
        (b"\x1b[1;05;31;8mred\x1b[m\n", b"\x1b[1;31mred\x1b[m\n"),
        (b"\x1b[0;6:1mfast\x1b[m\n", b"\x1b[0mfast\x1b[m\n"),
        (b"\x1b[38;5;208;48;5;8mx\x1b[m\n", b"\x1b[38;5;208;48;5;8mx\x1b[m\n"),
        (b"\x1b[38;2;5;6;8;8mx\x1b[m\n", b"\x1b[38;2;5;6;8mx\x1b[m\n"),
        (b"\x1b[38:5:8mx\x1b[m\n", b"\x1b[38:5:8mx\x1b[m\n"),
        (b"\x1b[38;8mx\x1b[m\n", b"\x1b[38mx\x1b[m\n"),
        (b"\x1b[1;3;4;7;9mx\x1b[m\n", b"\x1b[1;3;4;7;9mx\x1b[m\n"),
    ],
)
def test_escape_sequences_do_not_reach_a_terminal(written, shown):
    assert for_terminal(written) == shown


@given(
    st.lists(st.sampled_from([b"\xc2", b"\x9b", b"\x1b", b"[", b"5", b"8", b";", b"m", b"\x07"]))
)
def test_removing_sequences_does_not_create_new_ones(parts):
    shown = for_terminal(b"".join(parts) + b"\n")
    assert not set(b"\x07\x9b") & set(shown)
    for words in re.findall(rb"\x1b\[([0-9;]*)m", shown):
        assert not {b"5", b"6"} & set(words.split(b";"))
    assert for_terminal(shown) == shown


@pytest.mark.parametrize("sign", ["é", "€", "🤖"])
def test_a_character_whose_rest_is_still_to_come_waits(sign):
    whole = f"x{sign}".encode()
    assert whole_characters(whole) == whole
    assert {whole_characters(whole[:end]) for end in range(1, len(whole))} == {b"x"}
    assert whole_characters(b"x\xff") == b"x\xff"


def test_every_line_gets_the_prefix():
    assert with_prefix(b"[a] ", b"1\n\n2\n") == b"[a] 1\n[a] \n[a] 2\n"
