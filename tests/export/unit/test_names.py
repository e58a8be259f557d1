"""Names are legal, unique, and those that users guess."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.base.model.spec import ProcessSpec, RosIdentity
from launcher.export.unit_names import (
    MAX_DNS_LABEL,
    MAX_PREFIX,
    dns_label,
    file_name,
    is_prefix,
    names_of,
    unit_name,
)

LABEL = re.compile(r"[a-z]([a-z0-9-]*[a-z0-9])?")
UNIT = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")


def spec(label: str, node: str | None = None, namespace: str | None = None) -> ProcessSpec:
    ros = RosIdentity(node_name=node, namespace=namespace) if node else None
    return ProcessSpec(name=f"{label}-1", label=label, argv=(label,), env={}, ros=ros)


def units(*specs: ProcessSpec) -> list[str]:
    return [name.unit for name in names_of(specs)]


def test_a_node_has_its_name_and_another_process_its_label():
    (node, process) = names_of([spec("robot_node", "robot_1"), spec("Backup_DB")])
    assert (node.unit, node.label) == ("robot_1", "robot-1")
    assert (process.unit, process.label) == ("Backup_DB", "backup-db")


def test_nodes_of_one_name_are_told_apart_by_their_namespaces():
    found = units(spec("x", "robot", "/warehouse/a"), spec("x", "robot", "/warehouse/b"))
    assert found == ["warehouse-a-robot", "warehouse-b-robot"]


def test_what_is_still_the_same_gets_a_number():
    assert units(spec("x"), spec("x"), spec("x-2"), spec("x")) == ["x", "x-3", "x-2", "x-4"]


@pytest.mark.parametrize("name", ["sshd", "dbus", "systemd-resolved", "default"])
def test_units_of_the_system_are_not_replaced(name: str):
    assert units(spec(name)) == [f"{name}-node"]


def test_a_prefix_comes_first():
    (name,) = names_of([spec("x", "robot_1")], "fleet-")
    assert (name.unit, name.label) == ("fleet-robot_1", "fleet-robot-1")


@pytest.mark.parametrize("prefix", ["", "fleet-", "f", "F_2.x"])
def test_a_prefix_is_kept(prefix: str):
    assert is_prefix(prefix)
    assert unit_name(f"{prefix}robot_1") == f"{prefix}robot_1"


@pytest.mark.parametrize("prefix", ["ü-", "a b", "-a", "2-", ".a", "../", "a/b", "%i-", "a\n"])
def test_a_prefix_that_would_be_changed_is_none(prefix: str):
    assert not is_prefix(prefix)


def test_a_prefix_leaves_something_of_long_names():
    longest = "f" * MAX_PREFIX
    assert is_prefix(longest) and not is_prefix(f"{longest}f")
    (name,) = names_of([spec("x", "robot_" * 20)], longest)
    assert name.unit.startswith(f"{longest}robot_")


def test_a_prefix_leads_out_of_no_folder():
    (name,) = names_of([spec("x", "robot_1")], "../../etc/")
    assert (name.unit, name.label) == ("etc-robot_1", "etc-robot-1")


def test_long_names_are_told_apart_by_a_digest():
    first, second = (dns_label("n" * 80 + end) for end in "ab")
    assert first != second
    assert len(first) <= MAX_DNS_LABEL


@given(st.lists(st.text(max_size=90), min_size=1, max_size=6))
def test_names_are_legal_and_unique(labels: list[str]):
    names = names_of([spec(label) for label in labels])
    assert len({name.unit for name in names}) == len({name.label for name in names}) == len(labels)
    for name in names:
        assert LABEL.fullmatch(name.label)
        assert UNIT.fullmatch(name.unit)
        assert len(f"{name.label}-files") <= MAX_DNS_LABEL


@given(st.text(max_size=90))
def test_names_of_files_are_keys_of_config_maps(text: str):
    assert re.fullmatch(r"[A-Za-z0-9_.-]+", file_name(text))
    assert file_name(text).strip(".")
    assert unit_name(text)
