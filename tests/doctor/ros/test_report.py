"""`doctor --report`, of a domain with nodes."""

from __future__ import annotations

import pytest

from launcher.doctor import report
from tests.support.json_forms import fit
from tests.support.ros_domain import Verb

TITLES = (
    "platform information",
    "ros 2 information",
    "ros environment",
    "network configuration",
    "package versions",
    "node list",
    "qos compatibility list",
    "topic list",
    "service list",
    "action list",
)


def test_the_report_names_what_is_there(verb: Verb, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("ROS_SECRET_TOKEN", "pa55")
    answer = verb("doctor", "--report", "--json")
    assert answer.code == 0
    fit("doctor --report", answer.out)
    sections = {
        one["title"]: {entry["name"]: entry["value"] for entry in one["entries"]}
        for one in answer.json()["sections"]
    }
    assert tuple(sections) == TITLES
    assert "Python" in sections["platform information"]
    variables = sections["ros environment"]["ROS environment variables"]
    assert "ROS_DOMAIN_ID=" in variables
    assert "ROS_SECRET_TOKEN=..." in variables
    assert sections["package versions"]["std_msgs"].count(".") == 2
    assert sections["node list"]["node"]
    assert "reliability" in sections["qos compatibility list"]["/weak"].lower()
    assert sections["topic list"]["/chatter [std_msgs/msg/String]"].startswith("publishers ")
    assert sections["service list"]["/switch [std_srvs/srv/SetBool]"].startswith("servers 1")


def test_the_text_warns_first_and_says_what_is_empty():
    text = report.as_text(
        [report.ReportSection("ACTION LIST", ()), report.ReportSection("A", (("b", "c"),))]
    )
    assert text.splitlines()[0] == report.WARNING
    assert "   ACTION LIST\nnone" in text
    assert text.endswith("   A\nb : c")
