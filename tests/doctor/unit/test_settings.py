"""What the doctor says about variables of ROS and of the middleware."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.model.level import Level
from launcher.doctor.doctor_facts import Finding, SettingsFacts
from launcher.doctor.settings import collect_settings
from launcher.doctor.settings_checks import check_settings

PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
NEW_PROFILES = "FASTDDS_DEFAULT_PROFILES_FILE"
CYCLONE = {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}
SECURE = {"ROS_SECURITY_ENABLE": "true"}
BAD = "it is broken"


def mistakes(**facts: object) -> list[Finding]:
    """The findings, each with a repair, that are not ok."""
    found = check_settings(SettingsFacts(**facts))
    assert {finding.name for finding in found} == {"environment"}
    wrong = [finding for finding in found if finding.level is not Level.OK]
    assert all(finding.advice for finding in wrong)
    assert wrong or len(found) == 1
    return wrong


@pytest.mark.parametrize(
    ("values", "faults"),
    [
        ({}, {}),
        ({"FASTDDS_BUILTIN_TRANSPORTS": "LARGE_DATA?max_msg_size=1MB"}, {}),
        ({"ROS_LOCALHOST_ONLY": "0", "RCUTILS_COLORIZED_OUTPUT": "1"}, {}),
        ({PROFILES: "/p.xml"}, {}),
        ({PROFILES: "/p.xml", NEW_PROFILES: "/p.xml"}, {}),
        ({PROFILES: "/p.xml", **CYCLONE}, {PROFILES: BAD}),
        ({"CYCLONEDDS_URI": "file:///p.xml"}, {"CYCLONEDDS_URI": BAD}),
        ({"ROS_SECURITY_KEYSTORE": "/keys"}, {"ROS_SECURITY_KEYSTORE": BAD}),
        ({"ROS_SECURITY_KEYSTORE": "/keys", **SECURE}, {}),
    ],
)
def test_settings_that_have_their_effect(values: dict[str, str], faults: dict[str, str]):
    assert mistakes(values=values, faults=faults) == []


@pytest.mark.parametrize(
    ("values", "faults", "text"),
    [
        ({PROFILES: "/p.xml"}, {PROFILES: BAD}, f"{PROFILES} has no effect: {BAD}"),
        ({NEW_PROFILES: "/p.xml"}, {NEW_PROFILES: BAD}, f"{NEW_PROFILES} has no effect: {BAD}"),
        ({NEW_PROFILES: "/p.xml"}, {}, f"Fast DDS 2 reads {PROFILES}"),
        (
            {"FASTDDS_ENVIRONMENT_FILE": "/e"},
            {"FASTDDS_ENVIRONMENT_FILE": BAD},
            f"FASTDDS_ENVIRONMENT_FILE has no effect: {BAD}",
        ),
        ({"CYCLONEDDS_URI": "file:///p", **CYCLONE}, {"CYCLONEDDS_URI": BAD}, BAD),
        ({"FASTDDS_BUILTIN_TRANSPORTS": "UDP"}, {}, "takes it for DEFAULT"),
        ({"RMW_FASTRTPS_PUBLICATION_MODE": "sync"}, {}, "takes it for SYNCHRONOUS"),
        ({"ROS_LOCALHOST_ONLY": "yes"}, {}, "takes it for 0"),
        ({"ROS_SECURITY_ENABLE": "1"}, {}, "nodes have no security"),
        ({"RCUTILS_LOGGING_USE_STDOUT": "true"}, {}, "nodes print errors"),
        (SECURE, {}, "ROS_SECURITY_KEYSTORE is not set: nodes start without security"),
        ({**SECURE, "ROS_SECURITY_STRATEGY": "Enforce"}, {}, "no node can start"),
        (
            {**SECURE, "ROS_SECURITY_KEYSTORE": "/keys"},
            {"ROS_SECURITY_KEYSTORE": BAD},
            f"is true, and {BAD}: nodes start without security",
        ),
    ],
)
def test_settings_without_their_effect(values: dict[str, str], faults: dict[str, str], text: str):
    (finding,) = mistakes(values=values, faults=faults)
    assert finding.level is Level.PROBLEM and text in finding.text


def test_what_the_verbs_refuse_is_a_problem():
    (finding,) = mistakes(refusal=("RMW_IMPLEMENTATION is 'x'", "unset it"))
    assert (finding.level, finding.advice) == (Level.PROBLEM, "unset it")


# ---- looking


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (None, "No such file or directory"),
        ("<dds", "unclosed token in line 1"),
        ("<profile/>", "its first tag is <profile>, not <dds> or <profiles>"),
        ("<dds/>", None),
        ('<?xml version="1.0"?><profiles xmlns="http://www.eprosima.com"/>', None),
    ],
)
@pytest.mark.parametrize("name", [PROFILES, NEW_PROFILES])
def test_a_file_of_profiles_is_read(tmp_path: Path, name: str, content: str | None, fault: str):
    path = tmp_path / "profiles.xml"
    if content is not None:
        path.write_text(content)
    expected = {} if fault is None else {name: f"{path}: {fault}"}
    assert collect_settings({name: str(path)}).faults == expected


@pytest.mark.parametrize(
    ("name", "value", "fault"),
    [
        (PROFILES, "{}", "{} is no file"),
        ("CYCLONEDDS_URI", "<CycloneDDS/>,file://{}/x", "{}/x: No such file or directory"),
        ("CYCLONEDDS_URI", "<CycloneDDS/>", None),
        ("FASTDDS_ENVIRONMENT_FILE", "{}/x", "{}/x: No such file or directory"),
        ("ROS_SECURITY_KEYSTORE", "{}", "{} has no folder enclaves"),
    ],
)
def test_what_a_variable_names_is_looked_at(
    tmp_path: Path, name: str, value: str, fault: str | None
):
    found = collect_settings({name: value.format(tmp_path)}).faults
    assert found == ({} if fault is None else {name: fault.format(tmp_path)})


def test_the_refusal_is_that_of_the_verbs():
    refusal = collect_settings({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHSOT"}).refusal
    assert refusal == (
        "ROS_AUTOMATIC_DISCOVERY_RANGE is 'LOCALHSOT'",
        "did you mean 'LOCALHOST'?",
    )
    assert collect_settings({}).refusal is None


def test_the_new_name_has_its_effect_with_fast_dds_3():
    facts = SettingsFacts(values={NEW_PROFILES: "/p.xml"}, has_fast_dds_3=True)
    assert [one.level for one in check_settings(facts)] == [Level.OK]
