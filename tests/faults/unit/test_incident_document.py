"""Documents of incidents: what is wrong is named, and secrets are left out."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import pytest

from launcher.faults.incident import document
from launcher.faults.incident.document import IncidentError
from launcher.faults.incident.redaction import document_without_secrets, without_secrets
from tests.support.incidents import OPENED_S, incident_document


def test_a_whole_document_has_no_problems():
    incident = document.from_value(incident_document())

    assert incident.problems == ()
    assert incident.faults[0].fault == "no deaths: robot_1-3"
    assert incident.faults[2].notes == ("muted: known since Monday",)
    assert len(incident.events) == 8
    assert incident.processes_in_question == ("robot_1-3",)


def test_an_empty_object_is_an_incident_without_anything():
    incident = document.from_value({})

    assert (incident.title, incident.problems) == ("An incident without a title", ())


def test_a_title_that_is_only_what_was_seen_gets_its_fault():
    given = incident_document(title="0.4 Hz", faults=[{"fault": "x reports", "seen": "0.4 Hz"}])

    assert document.from_value(given).title == "x reports: 0.4 Hz"


def test_events_may_lack_their_monotonic_time():
    event = {"wall_s": OPENED_S, "event": "started", "process": "a-1", "pid": 3, "restarts": 0}

    assert len(document.from_value({"events": [event]}).events) == 1


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"format": 2}, "format 2 is newer than 1: what is new in it is not shown"),
        ({"number": "3"}, "number: '3' is not a whole number"),
        ({"title": ["a"]}, "title: ['a'] is not a text"),
        ({"opened_s": "now"}, "opened_s: 'now' is not a time in seconds since 1970"),
        ({"opened_s": 1e300}, "opened_s: 1e+300 is not a time in seconds since 1970"),
        ({"faults": {}}, "faults: {} is not a list"),
        ({"faults": [7]}, "faults[0]: 7 is not an object"),
        ({"faults": [{"first_s": True}]}, "faults[0].first_s: True is not a time in seconds"),
        ({"faults": [{"lines": [1]}]}, "faults[0].lines: [1] is not a list of texts"),
        ({"topics": {"/x": 4}}, "topics[/x]: 4 is not an object"),
        ({"topics": {"/x": {"arrivals": [1, "a"]}}}, "topics[/x].arrivals: 1 items are no times"),
        ({"machine": [[]]}, "machine: 1 items are no rows of 6 numbers"),
        ({"events": [{}]}, "events: 1 of 1 are no entries of an event log"),
        ({"graphs": []}, "graphs: [] is not an object"),
        ({"lines": [{}] * 5000}, "lines: the last 4000 of 5000 are shown"),
    ],
)
def test_what_is_wrong_is_named_and_the_rest_is_read(changes: dict[str, Any], problem: str):
    incident = document.from_value(incident_document(**changes))

    assert len(incident.problems) == 1
    assert incident.problems[0].startswith(problem)
    assert incident.launcher == "0.9.0"


@pytest.mark.parametrize("text", ["", "[", "[]", "null", "{}{}", '"a"', "\ufeff7", "[" * 300])
def test_what_is_no_document_is_an_error_with_its_path(tmp_path: Path, text: str):
    path = tmp_path / "3.json"
    path.write_text(text)

    with pytest.raises(IncidentError, match=r"3\.json"):
        document.read(str(path))


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("--password=hunter2 x", "--password=*** x"),
        ("--api-key hunter2 x", "--api-key *** x"),
        ("db_password:=hunter2", "db_password:=***"),
        ("-p wifi.psk:=hunter2", "-p wifi.psk:=***"),
        ("API_TOKEN=hunter2", "API_TOKEN=***"),
        ('{"secret": "hunter2", "a": 1}', '{"secret": ***, "a": 1}'),
        ("https://me:hunter2@host/x?a=1", "https://***@host/x?a=1"),
        ("http://host/?token=hunter2&a=1", "http://host/?token=***&a=1"),
        ("Authorization: Bearer hunter2hunter2", "Authorization: ***"),
        ("ghp_" + "a" * 36, "***"),
        ("AKIA" + "A" * 16, "***"),
        ("__node:=robot_1 speed:=2.0", "__node:=robot_1 speed:=2.0"),
        ("the token is gone; keys: 3; passing by", "the token is gone; keys: 3; passing by"),
        ("[robot_1]: author: me, compass: 3", "[robot_1]: author: me, compass: 3"),
    ],
)
def test_secrets_of_texts_are_left_out(text: str, shown: str):
    assert without_secrets(text) == shown


@pytest.mark.parametrize("piece", ["pass", "password-", "token=", "eyJaaaaaaaa-", "a://", "-_"])
def test_secrets_of_long_texts_take_linear_time(piece: str):
    def cpu_s(times: int) -> float:
        begin = time.process_time()
        without_secrets(piece * times)
        return time.process_time() - begin

    assert cpu_s(16_000) < 30 * (cpu_s(2000) + 0.01)


def test_secrets_of_plans_are_left_out():
    plan = {
        "cmd": ["node", "--password", "hunter2", "--token", "--flag", "x"],
        "env_set": {"ROS_DOMAIN_ID": "3", "HOME": "/home/hunter2", "X": "hunter2"},
        "env_unset": ["ROS_DISTRO", "HUNTER2"],
        "password": 1234,
        "parameters": [{"generated": {"mqtt": {"password": "hunter2", "port": 1}}}],
    }

    shown = document_without_secrets(plan)

    assert "hunter2" not in json.dumps(shown).lower()
    assert shown["cmd"] == ["node", "--password", "***", "--token", "--flag", "x"]
    assert shown["env_set"] == {"ROS_DOMAIN_ID": "3"}
    assert shown["password"] == "***"
    assert shown["parameters"][0]["generated"]["mqtt"]["port"] == 1


def test_the_document_itself_has_no_secrets():
    given = incident_document(title="call of https://me:hunter2@host failed")
    given["run"]["arguments"] = ["db_password:=hunter2"]
    given["lines"][0]["text"] = "login with token=hunter2"

    assert "hunter2" not in json.dumps(document.from_value(given).raw)
