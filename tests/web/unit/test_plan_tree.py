"""The tree of a launch file, with the names of a run."""

from __future__ import annotations

from typing import Any

from launcher.web.page_plan_tree import Tree, named


def entry(name: str | None, *children: dict[str, Any], text: str = "x") -> dict[str, Any]:
    fields = {"kind": "process", "detail": "", "place": None}
    return {**fields, "text": text, "name": name, "children": list(children)}


def started(*names: str) -> list[dict[str, Any]]:
    return [{"label": name.rpartition("-")[0], "name": name} for name in names]


def flat(tree: Tree | None) -> list[str | None]:
    assert tree is not None
    return [name for one in tree for name in (one["name"], *flat(one["children"]))]


def test_names_are_those_of_the_run():
    tree = [entry(None, entry("robot-2"), entry("late-3")), entry("other-1")]
    assert flat(named(tree, started("other-1", "late-2", "robot-3"))) == [
        *(None, "robot-3", "late-2"),
        "other-1",
    ]


def test_a_process_that_was_started_shows_its_name_of_the_run():
    tree = [entry("late-3", entry(None, text="log: x"), text="late"), entry("b-4", text="b")]
    found = named(tree, started("a-1", "late-2"))
    assert found is not None
    assert [found[0]["text"], found[0]["children"][0]["text"]] == ["late-2", "log: x"]
    assert (found[1]["text"], found[1]["name"]) == ("b", None)


def test_processes_of_one_label_are_matched_in_order():
    tree = [entry("sleep-10"), entry("sleep-9"), entry("sleep-11")]
    assert flat(named(tree, started("sleep-1", "sleep-2"))) == ["sleep-2", "sleep-1", None]


def test_what_the_run_has_more_is_left_out():
    assert flat(named([entry("a-1")], started("a-1", "b-2", "a-3"))) == ["a-1"]


def test_no_tree_is_no_tree():
    assert named(None, started("a-1")) is None
