"""The document of `param dump`."""

from __future__ import annotations

from launcher.ros.parameter_documents import dump_document


def test_groups_are_levels_unless_a_parameter_has_the_name_of_the_group():
    document = dump_document("/n", {"a": 1, "a.b": 2, "c.d.e": 3, "c.d": 4, "f.g": 5, "f.h": 6})
    assert document == {
        "/n": {
            "ros__parameters": {"a": 1, "a.b": 2, "c": {"d": 4, "d.e": 3}, "f": {"g": 5, "h": 6}}
        }
    }
