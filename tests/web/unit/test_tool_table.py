"""Which verbs are tools, and with which arguments."""

from __future__ import annotations

import jsonschema
import pytest

from launcher.base.option import option
from launcher.base.run_verb import BadCallError, Verb
from launcher.base.verb_table import TASK_OF
from launcher.control import verbs
from launcher.web.remote import tool_table
from launcher.web.remote.tool_table import LEFT_OUT, OF_STREAMS, tools


def test_every_verb_is_a_tool_or_left_out_with_a_reason():
    known = {*TASK_OF, *(verb.name for verb in verbs.VERBS)}

    assert {*tools()} | {*LEFT_OUT} == known
    assert {*tools()} & {*LEFT_OUT} == set()
    assert all(LEFT_OUT.values())


def test_every_option_of_a_verb_is_an_argument():
    for name, tool in tools().items():
        given = {one.name for one in tool.arguments} - {"run", "names", "limit"}
        if tool.verb is not None:
            verb = tool.verb
            rest = () if verb.rest is None else (verb.rest,)
            options = {one.name for one in (*verb.options, *verb.behind, *rest)}
            assert given == options - (OF_STREAMS if tool.verb.streams else set()), name


def test_commands_of_a_shell_write_no_files_and_do_not_go_on():
    for row in tool_table._SHELL:
        command = tool_table.command_of(row.name)
        names = {one.name for one in (*command.arguments, *command.all_options)}
        arguments = {one.name for one in tools()[row.name].arguments} - {"run"}
        assert arguments == names - row.left_out, row.name
        assert not arguments & {"svg", "html", "watch", "diff", "json", "domain"}


def test_the_schemas_are_schemas():
    for tool in tools().values():
        jsonschema.Draft202012Validator.check_schema(tool.schema())
        assert tool.description.endswith(".")


def test_read_only_tools_are_those_of_the_table():
    names = {*tools(read_only=True)}

    assert {"ps", "logs", "events", "info", "graph", "wait", "runs"} <= names
    assert not names & {"stop", "start", "restart", "kill", "send", "quit", "reload", "loglevel"}
    reading = {name for name, tool in tools().items() if tool.is_read_only}
    assert names - reading == {"faults"}  # which acknowledges and mutes, where that is allowed
    faults = tools()["faults"].only_reading
    assert faults is not None and [one.name for one in faults.arguments] == ["limit", "run"]
    assert tools(read_only=True)["faults"].arguments == faults.arguments
    assert tools()["stop"].only_reading is None


def test_a_verb_that_only_reads_without_an_option_lacks_it_where_only_reading_is_allowed(
    monkeypatch: pytest.MonkeyPatch,
):
    row = Verb(
        "flaws [NAME ...]",
        "list flaws",
        (option("--accept ID", "it is known"), option("--new", "only new ones")),
        streams=True,
        changing=("accept",),
    )
    monkeypatch.setattr(verbs, "VERBS", (*verbs.VERBS, row))
    monkeypatch.setattr(verbs, "READ_ONLY", verbs.READ_ONLY | {"flaws"})

    full, reading = tools()["flaws"], tools(read_only=True)["flaws"]

    assert [one.name for one in full.arguments] == ["names", "accept", "new", "limit", "run"]
    assert [one.name for one in reading.arguments] == ["names", "new", "limit", "run"]
    assert (full.is_read_only, reading.is_read_only) == (False, True)
    with pytest.raises(BadCallError) as refused:
        reading.checked({"accept": "x"})
    assert refused.value.code == "read-only"
    with pytest.raises(BadCallError) as unknown:
        reading.checked({"acept": "x"})
    assert unknown.value.code == "bad-option"
    assert verbs.only_reads("flaws", {"new": True})
    assert not verbs.only_reads("flaws", {"accept": "x"})


def test_a_server_of_one_run_has_no_choice_of_runs():
    found = tools(chooses_run=False)

    assert "runs" not in found
    assert not any(one.name == "run" for tool in found.values() for one in tool.arguments)


@pytest.mark.parametrize(
    ("name", "given", "problem"),
    [
        ("ps", {"name": ["a"]}, "ps has no argument 'name'"),
        ("ps", {"names": "a"}, "ps: 'names' must be a list of strings"),
        ("ps", {"names": [1]}, "ps: 'names' must be a list of strings"),
        ("wait", {"names": ["a\0"]}, "wait: 'names' must be a list of strings"),
        ("wait", {"topics": ["\ud800"]}, "wait: 'topics' must be a list of strings"),
        ("send", {"names": ["a"], "text": "\0"}, "send: 'text' must be a string"),
        ("ps", {"responsive": 1}, "ps: 'responsive' must be true or false"),
        ("stop", {}, "stop needs 'names'"),
        ("send", {"names": ["a", "b"], "text": "x"}, "send: 'names' must be at most 1 values"),
        ("send", {"names": ["a"]}, "send needs 'text'"),
        ("logs", {"limit": 1001}, "logs: 'limit' must be at most 1000"),
        ("logs", {"limit": True}, "logs: 'limit' must be a whole number of at least 0"),
        ("logs", {"follow": True}, "logs has no argument 'follow'"),
        ("wait", {"timeout": 0}, "wait: 'timeout' must be a number of seconds above 0"),
        ("wait", {"timeout": 601}, "wait: 'timeout' must be at most 600"),
        ("wait", {"timeout": float("nan")}, "wait: 'timeout' must be a number of seconds above 0"),
        ("wait", {"state": "asleep"}, "wait: 'state' must be one of running, ready, ended"),
        ("graph", {"svg": "/etc/x"}, "graph has no argument 'svg'"),
    ],
)
def test_bad_arguments_are_refused(name: str, given: dict[str, object], problem: str):
    with pytest.raises(BadCallError, match="^" + problem.replace("(", "\\(")):
        tools()[name].checked(given)


def test_absent_arguments_have_their_defaults():
    assert tools()["logs"].checked({"names": None}) == {"limit": 100}
    assert tools()["wait"].checked({"names": ["a"]}) == {"names": ["a"], "timeout": 60}


def test_words_of_a_caller_are_never_options():
    tool = tools()["wait"]
    given = {"names": ["--run=x", "a"], "topics": ["/t", "--debug"], "timeout": 2}

    words = tool.words(tool.checked(given))

    assert words == ["--topic=/t", "--topic=--debug", "--timeout=2", "--", "--run=x", "a"]
    graph = tools()["graph"]
    flags = {"hidden": True, "debug_topics": False, "mode": "nodes"}
    assert graph.words(graph.checked(flags)) == ["--mode=nodes", "--hidden"]


def test_values_of_an_address_are_read_as_their_kind():
    arguments = {one.name: one for one in (*tools()["wait"].arguments, *tools()["logs"].arguments)}

    assert arguments["names"].from_words(["a", "b"], "wait") == ["a", "b"]
    assert arguments["timeout"].from_words(["1.5"], "wait") == 1.5
    assert arguments["limit"].from_words(["5"], "logs") == 5
    hidden = next(one for one in tools()["graph"].arguments if one.name == "hidden")
    assert [hidden.from_words([word], "graph") for word in ("true", "0")] == [True, False]
    for name, word in (("limit", "x"), ("limit", "-1"), ("timeout", "inf"), ("timeout", "soon")):
        with pytest.raises(BadCallError, match=f"'{name}' must be"):
            arguments[name].from_words([word], "x")
    with pytest.raises(BadCallError, match="true or false"):
        hidden.from_words(["maybe"], "graph")
