"""`topic echo`, `hz`, `bw`, `delay`, `pub`, `type` and `find` against real publishers."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys

import pytest

from tests.support.node_process import line_of, without_complaints
from tests.support.variations import few_of
from tests.support.verbs import TIMEOUT_S, Answer, eventually, going_on
from tests.support.waiting import wait_until

RELAY = ("/relay", "geometry_msgs/msg/Point")
ECHO = (sys.executable, "-m", "launcher", "topic", "echo")


def test_echo_once_prints_one_message_and_accepts_a_name_without_slash(verb):
    answer = verb("topic", "echo", "chatter", "--once")
    assert re.fullmatch(r"data: msg \d+\n---\n", answer.out)
    assert (answer.err, answer.code) == ("", 0)


def test_echo_of_a_latched_topic_prints_the_backlog_and_ends_after_the_timeout(verb):
    words = ("topic", "echo", "/latched", "--timeout", "3", "--flow-style")
    backlog = "".join(f"data: {n}\n---\n" for n in range(3, 8))
    answer = eventually(lambda: verb(*words), lambda answer: len(answer.out) >= len(backlog))
    assert (answer.out, answer.code) == (backlog, 0)


def test_the_timeout_of_echo_ends_it_although_messages_arrive(verb):
    def span_s(answer: Answer) -> float:
        times = [json.loads(line)["info"]["received_timestamp"] for line in answer.lines]
        return (max(times) - min(times)) / 1e9 if times else 0.0

    # What arrives while the verb itself is held up at its end is printed as well.
    words = ("topic", "echo", "/chatter", "--timeout", "2", "--json", "-i")
    answer = eventually(lambda: verb(*words), lambda answer: 0.0 < span_s(answer) < 2.5)
    assert answer.code == 0


@pytest.mark.parametrize(
    ("options", "pattern"),
    [
        (["/chatter", "--csv"], r"msg \d+\n"),
        (["/chatter", "--field", "data"], r"msg \d+\n---\n"),
        (["/chatter", "--no-str"], r"data: '<string length: <\d>>'\n---\n"),
        (["/chatter", "-l", "3"], r"data: msg\.\.\.\n---\n"),
        (["/chatter", "--raw"], r"b'\\x00\\x01.*'\n---\n"),
        (
            ["/chatter", "-i"],
            r"publication_sequence_number: \d+\nreceived_timestamp: \d+\n"
            r"reception_sequence_number: null\nsource_timestamp: \d+\n---\ndata: msg \d+\n---\n",
        ),
        (["/chatter", "--filter", "m.data.endswith('5')"], r"data: msg \d*5\n---\n"),
        (["/points", "--field", "point.x"], r"0\.5\n---\n"),
        (
            ["/points", "--field", "point.x", "--field", "header.frame_id", "--field", "point"],
            r"0\.5\nmap\nx: 0\.5\ny: 0\.0\nz: 0\.0\n---\n",
        ),
        (
            ["/points", "--field", "point.x", "--field", "point", "--csv"],
            r"0\.5\n0\.5,0\.0,0\.0\n",
        ),
        (["/numbers", "--field", "data.[3]", "--field", "data[4]"], r"3\.0\n4\.0\n---\n"),
        (["/chatter", "--clear"], r"data: msg \d+\n---\n"),  # only a terminal is cleared
        (
            ["/numbers", "--no-arr", "--field", "data", "--csv"],
            r"array\('d', \[0\.0, .*\]\)\n",
        ),
        (["/numbers"], r"(?s).*\n- 127\.0\n- '\.\.\.'\n---\n"),
        (["/numbers", "-f"], r"(?s).*\n- 199\.0\n---\n"),
    ],
    ids=lambda value: " ".join(value[1:]) if isinstance(value, list) else "",
)
def test_echo_has_the_shapes_of_ros2(verb, options, pattern):
    answer = verb("topic", "echo", *options, "--once")
    assert re.fullmatch(pattern, answer.out), answer
    assert answer.code == 0


def test_echo_of_several_topics_has_a_prefix(verb):
    answer = verb("topic", "echo", "/chatter", "/latched", "/weak", "--once")
    assert re.match(r"\[/(chatter|latched|weak)\] data: ", answer.out)


def test_echo_as_json_is_one_line_per_message(verb):
    answer = verb("topic", "echo", "/numbers", "--json", "--once")
    document = json.loads(answer.out)
    assert answer.out.count("\n") == 1
    assert document["message"]["data"] == [float(n) for n in range(200)]


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["/chatter", "--field", "nope"], "Invalid field 'nope': 'String' object has no attribute"),
        (["/chatter", "--field", "."], "Invalid field value '.'\n"),
        (["/chatter", "std_msgs/msg/Strnig"], "did you mean String? (std_msgs/msg/String)"),
        (["/chater"], "Could not determine the type for the passed topic\nhint: did you mean"),
        (["bad topic!"], "or '/': '/bad topic!'\n"),
        ([""], "Invalid topic name: topic name must not be empty: ''\n"),
        (
            ["/chatter", "nonsense"],
            "type is invalid\nhint: 'nonsense' is neither a further topic",
        ),
        (["/chatter", "/weak", "a/B"], "type is invalid\nhint: 'a/B' is neither a further topic"),
        (["/chatter", "--filter", "m.dta"], "--filter failed: AttributeError"),
        (["/chatter", "--filter", "next(iter(()))"], "--filter failed: StopIteration\n"),
    ],
    ids=[
        "field",
        "dot",
        "type",
        "topic",
        "name",
        "empty",
        "neither",
        "several",
        "filter",
        "silent",
    ],
)
def test_echo_errors_say_what_is_wrong(verb, words, error):
    answer = verb("topic", "echo", *words, "--once")
    assert error in answer.err
    assert answer.code == 1


def test_a_bad_filter_is_a_usage_error(verb):
    answer = verb("topic", "echo", "/chatter", "--filter", "m.(")
    assert (answer.code, "not a Python expression" in answer.err) == (2, True)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (
            ["/weak", "--qos-reliability", "reliable"],
            "RELIABILITY: the publisher offers BEST_EFFORT",
        ),
        (["/chatter", "std_msgs/msg/Int32"], "TYPE: the publisher offers std_msgs/msg/String"),
        (["/chatter", "--qos-durability", "transient_local"], "DURABILITY: the publisher offers"),
    ],
    ids=["reliability", "type", "durability"],
)
def test_echo_says_why_it_stays_silent(verb, words, reason):
    ask = ("topic", "echo", *words, "--timeout", "1")
    answer = eventually(lambda: verb(*ask), lambda answer: reason in answer.err)
    assert answer.out == ""


def test_hz_measures_and_keeps_the_promise_of_min(verb):
    words = ("topic", "hz", "/chatter", "--for", "3", "--min", "1")
    pattern = r"average rate: (\d+\.\d{3})\n\tmin: (\S+)s max: (\S+)s std dev: \S+s window: \d+\n"

    def is_near(answer: Answer) -> bool:
        """Published at 10 Hz by a timer: of two messages, the first may be late."""
        found = re.findall(pattern, answer.out)
        return answer.code == 0 and bool(found) and 1 < float(found[-1][0]) < 20

    answer = eventually(lambda: verb(*words), is_near)
    for numbers in re.findall(pattern, answer.out):
        rate, least_s, most_s = map(float, numbers)
        assert 1 / (most_s + 0.001) <= rate <= 1 / max(0.001, least_s - 0.001)


def test_hz_below_the_minimum_exits_with_1(verb):
    # more than two messages of which the first was late
    answer = verb("topic", "hz", "/chatter", "--for", "1", "--min", "100000", "--json")
    assert answer.code == 1
    assert json.loads(answer.lines[-1])["mean_hz"] < 100000


def test_hz_min_without_for_is_a_usage_error(verb):
    assert verb("topic", "hz", "/chatter", "--min", "5").code == 2


def test_bw_counts_bytes(verb):
    words = ("topic", "bw", "/chatter", "--for", "1.5")
    answer = eventually(lambda: verb(*words), lambda answer: "B/s" in answer.out)
    assert answer.lines[0] == "Subscribed to [/chatter]"
    assert re.search(r"\d+ B/s from \d+ messages\n\tMessage size mean: \d+ B", answer.out)


def test_delay_reads_the_stamps_and_complains_where_there_are_none(verb):
    answer = eventually(
        lambda: verb("topic", "delay", "/points", "--for", "1.5"), lambda answer: answer.out
    )
    assert re.match(r"average delay: \d\.\d{3}\n\tmin: ", answer.out)
    without = verb("topic", "delay", "/chatter", "--for", "60")  # ends with the first message
    assert (without.code, "msg does not have header" in without.err) == (1, True)


def test_type_and_find(verb):
    assert verb("topic", "type", "/chatter").out == "std_msgs/msg/String\n"
    unknown = verb("topic", "type", "/nosuch")
    assert (unknown.out, unknown.code) == ("", 1)
    assert verb("topic", "find", "std_msgs/msg/String").lines == ["/chatter", "/weak"]
    assert verb("topic", "find", "std_msgs/String").lines == ["/chatter", "/weak"]
    assert verb("service", "find", "std_srvs/SetBool").lines == ["/switch"]
    misspelt = verb("topic", "find", "std_msgs/Strnig")
    assert (misspelt.out, misspelt.code) == ("", 0)  # somebody may have it
    assert misspelt.err == "hint: did you mean std_msgs/msg/String?\n"


def test_pub_prints_what_it_sends(verb):
    words = ("topic", "pub", "/pp", "std_msgs/msg/String", "data: hi", "-w", "0")
    assert verb(*words, "-t", "2", "-r", "50").out == (
        "publisher: beginning loop\n"
        "publishing #1: std_msgs.msg.String(data='hi')\n\n"
        "publishing #2: std_msgs.msg.String(data='hi')\n\n"
    )


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["std_msgs/String", "nope: 1"], "'String' object has no attribute 'nope'"),
        (["std_msgs/Strnig", "data: x"], "did you mean String?"),
        (["std_msgs/Int32", "data: x"], "'data' takes a whole number"),
        (["std_msgs/String", "data: 'x"], "The passed value is not YAML"),
    ],
    ids=["field", "type", "value", "yaml"],
)
def test_pub_refuses_before_anything_is_published(verb, words, error):
    answer = verb("topic", "pub", "/pp", *words, "-w", "0", "--once")
    assert (answer.out, answer.code) == ("", 1)
    assert error in answer.err


def test_what_pub_sends_echo_receives_from_stdin_to_stdout(verb, env):
    echo = subprocess.Popen(
        # RELIABLE, or the one message may come before echo knows who sends it
        [*ECHO, *RELAY, "--once", "--csv", "--qos-reliability", "reliable"],
        env=env,
        stdout=subprocess.PIPE,
        text=True,
    )
    sent = verb("topic", "pub", *RELAY, "--once", "--stdin", text="y: 2")
    out, _ = echo.communicate(timeout=TIMEOUT_S)
    assert "publishing #1: geometry_msgs.msg.Point(x=0.0, y=2.0, z=0.0)" in sent.out
    assert without_complaints(out) == "0.0,2.0,0.0\n"


def test_text_is_sent_as_utf_8_and_shown_with_escapes_in_any_locale(env):
    ascii_env = {**env, "PYTHONIOENCODING": "ascii"}
    command = [*ECHO, "/words", "std_msgs/msg/String", "--once", "--json"]
    command += ["--qos-reliability", "reliable"]
    echo = subprocess.Popen(command, env=ascii_env, stdout=subprocess.PIPE, text=True)
    words = ("topic", "pub", "/words", "std_msgs/msg/String", "--once", "--stdin")
    sent = subprocess.run(
        [sys.executable, "-m", "launcher", *words],
        env=ascii_env,
        input="data: größe ─ 🤖".encode(),
        capture_output=True,
        timeout=TIMEOUT_S,
    )
    assert sent.returncode == 0, sent.stderr.decode()
    out, _ = echo.communicate(timeout=TIMEOUT_S)
    assert json.loads(without_complaints(out))["message"] == {"data": "größe ─ 🤖"}


@pytest.mark.parametrize("signum", few_of([signal.SIGINT, signal.SIGTERM], [signal.SIGTERM]))
def test_echo_ends_quietly_on_a_signal(env, signum):
    echo = subprocess.Popen(
        [*ECHO, "/chatter"],
        env=env,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert line_of(echo.stdout).startswith("data: msg")
    echo.send_signal(signum)
    _, errors = echo.communicate(timeout=TIMEOUT_S)
    assert (without_complaints(errors), echo.returncode) == ("", 0)


def test_a_reader_that_has_enough_ends_echo_quietly(env):
    echo = subprocess.Popen(
        [*ECHO, "/chatter"],
        env=env,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert echo.stdout is not None
    assert echo.stderr is not None
    line_of(echo.stdout)
    echo.stdout.close()
    wait_until(lambda: echo.poll() is not None, "echo has ended")
    assert (without_complaints(echo.stderr.read()), echo.returncode) == ("", 0)
    echo.stderr.close()


@pytest.mark.thorough
def test_a_filter_looks_at_each_of_several_fields(verb):
    words = ("--field", "data[1]", "--field", "data[2]", "--field", "data[3]", "--once")
    answer = verb("topic", "echo", "/numbers", *words, "--filter", "m > 1")
    assert answer.out == "2.0\n3.0\n---\n"
    answer = verb("topic", "echo", "/numbers", *words, "--filter", "m == 2", "--json")
    assert answer.json()["message"] == {"data[2]": 2.0}


@pytest.mark.thorough
def test_the_node_that_subscribes_may_have_a_name(verb, env):
    with going_on(env, "topic", "echo", "/chatter", "-n", "listening_in") as echo:
        assert line_of(echo.stdout).startswith("data: msg")
        listed = eventually(lambda: verb("node", "list"), lambda one: "listening_in" in one.out)
        assert "/listening_in" in listed.lines
        told = verb("topic", "info", "/chatter", "-v", "--json").json()
        assert "/listening_in" in [one["node"] for one in told["endpoints"]]
    wrong = verb("topic", "echo", "/chatter", "-n", "1x")
    assert (wrong.code, wrong.err.startswith("error: --node-name: ")) == (2, True)


def test_a_filter_looks_at_the_field_that_is_asked_for(verb):
    words = ("--field", "data[3]", "--filter", "m == 3.0", "--once")
    assert verb("topic", "echo", "/numbers", *words).out == "3.0\n---\n"


@pytest.mark.thorough
def test_a_publisher_that_does_not_match_is_named_while_another_is_received(verb, env):
    weak = ("topic", "pub", "/mixed", "std_msgs/msg/String", "data: weak", "-n", "weak_one")
    strong = ("topic", "pub", "/mixed", "std_msgs/msg/String", "data: strong", "-n", "strong_one")
    ask = ("topic", "echo", "/mixed", "std_msgs/msg/String", "--qos-reliability", "reliable")
    with (
        going_on(env, *weak, "-r", "5", "--qos-reliability", "best_effort"),
        going_on(env, *strong, "-r", "5"),
    ):
        answer = eventually(
            lambda: verb(*ask, "--timeout", "3"),
            lambda answer: (
                "strong" in answer.out
                and "nothing will be received on /mixed from /weak_one:\n" in answer.err
            ),
        )
    assert "UNKNOWN" not in answer.err
    assert "weak" not in answer.out
