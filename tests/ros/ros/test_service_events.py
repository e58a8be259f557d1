"""`service info` and `service echo`, and the events as messages of a topic."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from tests.support.node_process import line_of
from tests.support.ros_domain import Verb, patient_verb, ros_domain, talking
from tests.support.verbs import Answer, eventually, going_on

TOPIC = "/told/_service_event"
KINDS = {"REQUEST_SENT", "REQUEST_RECEIVED", "RESPONSE_SENT", "RESPONSE_RECEIVED"}
UNTOLD = (
    "No publishers on topic '/untold/_service_event'; "
    "is service introspection on the client or server enabled?\n"
)


@pytest.fixture
def here(tmp_path: Path) -> Iterator[dict[str, str]]:
    """A domain with a service that is called ten times a second, and tells it."""
    with ros_domain(tmp_path) as env, talking(env, "tests.support.introspected_service"):
        yield env


@pytest.fixture
def service(here: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> Verb:
    return patient_verb(here, monkeypatch)


def read_events(env: dict[str, str], *words: str) -> list[dict]:
    """Four events of `service echo`, each as its YAML says."""
    documents = []
    with going_on(env, "service", "echo", *words) as program:
        while len(documents) < 4:
            text = "".join(iter(lambda: line_of(program.stdout), "---\n"))
            documents.append(yaml.safe_load(text[text.index("info:") :]))
    return documents


def test_info_counts_the_clients_and_servers(service):
    told = service("service", "info", "/told")
    assert told.out == "Type: std_srvs/srv/SetBool\nClients count: 1\nServices count: 1\n"
    assert service("service", "info", "untold").lines[1:] == [
        "Clients count: 0",
        "Services count: 1",
    ]
    document = service("service", "info", "/told", "--json").json()
    assert (document["clients"], document["servers"]) == (["/introspected"], ["/introspected"])
    unknown = service("service", "info", "/tolled")
    assert (unknown.out, unknown.code) == ("", 1)
    assert unknown.err == "Unknown service '/tolled'\nhint: did you mean '/told'?\n"


@pytest.mark.thorough
@pytest.mark.parametrize("words", [["/told"], ["told", "std_srvs/srv/SetBool", "--flow-style"]])
def test_events_have_names_and_contents(here, words):
    for event in read_events(here, *words):
        assert list(event) == ["info", "request", "response"]
        kind = event["info"]["event_type"]
        assert kind in KINDS
        assert len(event["info"]["client_gid"]) == 16
        is_request = kind.startswith("REQUEST")
        assert event["request"] == ([{"data": True}] if is_request else [])
        answer = [] if is_request else [{"success": True, "message": "answered"}]
        assert event["response"] == answer


@pytest.mark.thorough
def test_the_styles_of_events(here):
    with going_on(here, "service", "echo", "/told", "--csv", "--no-str") as program:
        rows = [line_of(program.stdout).rstrip("\n").split(",") for _ in range(4)]
    for row in rows:
        assert row[0] in "0123"
        assert row[20:] in (["True", ""], ["", "True", "<string length: <8>>"])
    with going_on(here, "service", "echo", "/told", "--json") as program:
        document = json.loads(line_of(program.stdout))
    assert document["topic"] == TOPIC
    assert document["message"]["info"]["event_type"] in KINDS
    (event, *_) = read_events(here, "/told", "--no-arr")
    assert event["info"]["client_gid"] == "<array type: uint8[16]>"


@pytest.mark.thorough
def test_a_service_without_introspection_is_told_so(service):
    answer = service("service", "echo", "/untold", "--timeout", "1")
    nothing = "no message on /untold/_service_event within 1 s\n"
    assert (answer.out, answer.err, answer.code) == (UNTOLD, nothing, 1)
    as_json = service("service", "echo", "/untold", "--timeout", "1", "--json")
    assert (as_json.out, as_json.err) == ("", UNTOLD + nothing)


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (
            ["/tolled"],
            "Cannot find type for '/tolled'\nhint: did you mean '/told'?\n",
        ),
        (
            ["/told", "std_srvs/srv/SetBol"],
            "The service type 'std_srvs/srv/SetBol' is invalid\n"
            "hint: did you mean SetBool? (std_srvs/srv/SetBool)\n",
        ),
        (["bad name!", "std_srvs/srv/SetBool"], "Invalid topic name: "),
    ],
    ids=["name", "type", "invalid"],
)
def test_echo_errors(service, words, error):
    answer = service("service", "echo", *words, "--spin-time", "2")
    assert (answer.err.startswith(error), answer.code) == (True, 1), answer


@pytest.mark.thorough
def test_events_are_messages_of_a_topic(here, service):
    shown = service("topic", "echo", TOPIC, "--once")
    (document, _) = yaml.safe_load_all(shown.out)
    assert document["info"]["event_type"] in range(4)
    typed = service("topic", "echo", TOPIC, "std_srvs/srv/SetBool_Event", "--once", "--csv")
    assert typed.out.count(",") >= 21

    def measure() -> Answer:
        return service("topic", "hz", TOPIC, "--for", "3")

    assert "average rate: " in eventually(measure, lambda answer: answer.out).out
    hidden = ("--include-hidden-topics",)
    assert service("topic", "find", "std_srvs/srv/SetBool_Event", *hidden).lines == [TOPIC]
    event = "{info: {event_type: 3}, response: [{message: mine}]}"
    publish = ("topic", "pub", "/mine", "std_srvs/srv/SetBool_Event", event, "-r", "20", "-w", "0")
    with going_on(here, *publish):
        mine = service("topic", "echo", "/mine", "std_srvs/srv/SetBool_Event", "--once")
    (document, _) = yaml.safe_load_all(mine.out)
    assert document["response"] == [{"success": False, "message": "mine"}]
