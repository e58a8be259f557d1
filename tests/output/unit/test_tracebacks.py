"""Tracebacks are kept whole; one of an ordinary stop is folded into a line."""

from hypothesis import given
from hypothesis import strategies as st

from launcher.output.tracebacks import HELD_LIMIT, TracebackGate

FRAMES = b'Traceback (most recent call last):\n  File "x.py", line 1, in <module>\n    f()\n'
ERROR = FRAMES + b"ValueError: no\n"
STOP = FRAMES + b"KeyboardInterrupt\n"


def test_lines_without_a_traceback_pass_at_once():
    gate = TracebackGate()
    assert gate.feed(b"a\nb\n", stopping=False) == b"a\nb\n"
    assert not gate.holds


def test_a_traceback_that_comes_line_by_line_passes_as_one_block():
    gate = TracebackGate()
    passed = [gate.feed(line + b"\n", stopping=False) for line in ERROR[:-1].split(b"\n")]
    assert passed == [b"", b"", b"", ERROR]


def test_what_stands_before_and_after_passes_in_order():
    gate = TracebackGate()
    assert gate.feed(b"before\n" + ERROR + b"after\n", stopping=False) == (
        b"before\n" + ERROR + b"after\n"
    )


def test_the_traceback_of_a_stop_is_folded_only_while_stopping():
    assert TracebackGate().feed(STOP, stopping=False) == STOP
    folded = TracebackGate().feed(STOP + b"bye\n", stopping=True)
    assert folded.count(b"\n") == 2
    assert b"ended by KeyboardInterrupt" in folded
    assert folded.endswith(b"bye\n")


ROSOUT = b"Failed to publish log message to rosout: publisher's context is invalid, at ./x.c:4\n"


def test_rcls_remark_on_a_message_after_the_shutdown_is_kept_back_only_while_stopping():
    assert TracebackGate().feed(ROSOUT, stopping=False) == ROSOUT
    lines = b"[INFO] goodbye\n" + ROSOUT + b"\x1b[0m" + ROSOUT + b"said: " + ROSOUT
    passed = TracebackGate().feed(lines, stopping=True)
    assert passed == b"[INFO] goodbye\nsaid: " + ROSOUT
    assert TracebackGate().feed(ROSOUT, stopping=True) == b""


def test_rclpys_exception_is_known_with_its_module_and_in_colour():
    colourful = FRAMES + b"\x1b[1;35mrclpy.executors.ExternalShutdownException\x1b[0m\n"
    assert b"ended by ExternalShutdown" in TracebackGate().feed(colourful, stopping=True)


def test_another_error_during_a_stop_is_shown_whole():
    assert TracebackGate().feed(ERROR, stopping=True) == ERROR


def test_two_tracebacks_in_one_read_are_each_looked_at():
    out = TracebackGate().feed(STOP + ERROR, stopping=True)
    assert out.endswith(ERROR)
    assert b"ended by" in out


def test_an_endless_traceback_is_passed_on():
    gate = TracebackGate()
    out = gate.feed(FRAMES + b"  x\n" * HELD_LIMIT, stopping=False)
    assert out.startswith(FRAMES)
    assert not gate.holds


@given(st.lists(st.sampled_from([b"x\n", b"  y\n", b"\n", FRAMES, b"E: z\n"]), max_size=12))
def test_nothing_is_lost_or_reordered(blocks):
    gate = TracebackGate()
    out = b"".join(gate.feed(block, stopping=False) for block in blocks) + gate.flush()
    assert out == b"".join(blocks)
