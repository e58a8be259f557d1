"""How each verb parses its arguments; these command lines must keep their meaning."""

from __future__ import annotations

import importlib
import os
import shlex
from pathlib import Path
from typing import Any

import pytest

from launcher import cli
from launcher.commands import args, control, doctor, launch, plan, run, smoke
from launcher.control import verbs
from launcher.errors import LauncherError, UsageError
from launcher.model.options import RunOptions
from launcher.model.spec import RestartMode

LAUNCH_FILE = """
from launch import LaunchDescription

def generate_launch_description():
    return LaunchDescription([])
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with `a.launch.py`, in which the words are read."""
    (tmp_path / "a.launch.py").write_text(LAUNCH_FILE, encoding="utf-8")
    (tmp_path / "e.yaml").write_text("expect:\n  - {node: /from_file}\n", encoding="utf-8")
    (tmp_path / "budgets.yaml").write_text("x: {fds: 9, nice: 3}\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def differing(given: object, default: object) -> dict[str, Any]:
    """The attributes in which two values of the same class differ."""
    return {key: value for key, value in vars(given).items() if value != getattr(default, key)}


# ---- launch, plan, args


@pytest.fixture
def launched(monkeypatch) -> Any:
    """What `launch WORDS` would do: (verb, arguments, options, run options, time limit)."""
    seen: list[Any] = []

    def note(verb: str, request: Any, options: Any = None) -> int:
        flags = {name for name in ("lenient", "noninteractive") if getattr(request, name)}
        run_options = {} if options is None else differing(options, RunOptions())
        arguments = dict(request.arguments)
        seen.append((verb, arguments, flags, run_options, request.time_limit.wall_s))
        return 0

    def listed(request: Any) -> int:
        seen.append(("args", request.path, request.time_limit.wall_s))
        return 0

    def planned(request: Any, *, as_json: bool = False) -> int:
        note("plan", request)
        if as_json:
            seen[-1][2].add("json")
        return 0

    monkeypatch.setattr(launch, "launch", lambda request, options: note("launch", request, options))
    monkeypatch.setattr(plan, "show", planned)
    monkeypatch.setattr(args, "show", listed)

    def read(verb: Any, words: list[str]) -> Any:
        assert verb.main(words) == 0
        return seen.pop()

    return read


F = "a.launch.py"
ONCE = ("x", RestartMode.ALWAYS)


@pytest.mark.parametrize(
    ("line", "arguments", "flags", "run_options"),
    [
        (F, {}, {}, {}),
        (f"{F} a:=1 b:=x:=y", {"a": "1", "b": "x:=y"}, {}, {}),
        (f"--lenient {F} a:=1 --debug", {"a": "1"}, {"--lenient": "", "-d": ""}, {}),
        (f"-d -n -a {F}", {}, {"-d": "", "-n": "", "-a": ""}, {}),
        (f"{F} --noninteractive", {}, {"-n": ""}, {}),
        (f"{F} --show-all-subprocesses-output", {}, {"-a": ""}, {}),
        (f"{F} -- a:=1", {"a": "1"}, {}, {}),
        (f"-- {F} a:=1", {"a": "1"}, {}, {}),
        (f"--launch-prefix 'nice -n 5' {F}", {"launch-prefix": "nice -n 5"}, {}, {}),
        (
            f"{F} a:=1 --launch-prefix=x --launch-prefix-filter=y",
            {"a": "1", "launch-prefix": "x", "launch-prefix-filter": "y"},
            {},
            {},
        ),
        (f"{F} --no-console --no-log-files", {}, {}, {"console": False, "log_files": False}),
        (
            f"--no-control {F} --exit-when-any-dies",
            {},
            {},
            {"control": False, "exit_when_any_dies": True},
        ),
        (f"{F} --ros", {}, {}, {"ros": True}),
        (f"--timeout 2.5 {F}", {}, {}, {"timeout_s": 2.5}),
        (f"--timeout=1 {F} --timeout=0.5", {}, {}, {"timeout_s": 0.5}),
        (f"{F} --stagger .5 --max-starting 3", {}, {}, {"stagger_s": 0.5, "max_starting": 3}),
        (f"{F} --required a --required=b*", {}, {}, {"required": ("a", "b*")}),
        (f"{F} --budget x:fds=9 --budget=y:cpu=1", {}, {}, {"budgets": ("x:fds=9", "y:cpu=1")}),
    ],
    ids=str,
)
def test_words_of_a_launch(launched, line, arguments, flags, run_options, monkeypatch):
    monkeypatch.setenv("OVERRIDE_LAUNCH_PROCESS_OUTPUT", "")
    names = {"--lenient": "lenient", "-n": "noninteractive"}
    verb, found, options, found_run, wall_s = launched(launch, shlex.split(line))
    assert (verb, found, found_run, wall_s) == ("launch", arguments, run_options, 60.0)
    assert options == {names[flag] for flag in flags if flag in names}
    is_all = os.environ["OVERRIDE_LAUNCH_PROCESS_OUTPUT"] == "both"
    assert is_all == ("-a" in flags)


def test_options_about_processes_keep_their_order(launched):
    words = ["--nice", "x=1", F, "--budgets", "budgets.yaml", "--nice=x=2", "--restart", "x=always"]
    more = ["--stop", "x=int:1", "--cpus=x=0", "--limit", "x:nofile=9"]
    run_options = launched(launch, [*words, *more])[3]
    nices = [limits.nice for _, limits in run_options["limits"]]
    assert nices == [1, 3, 2, None, None]
    assert [pattern for pattern, _ in run_options["stop"]] == ["x"]
    assert [(p, policy.mode) for p, policy in run_options["restart"]] == [ONCE]
    assert run_options["budget_files"] == (("budgets.yaml", "x: {fds: 9, nice: 3}\n"),)
    assert run_options["file_names"] == (("x", "budgets.yaml:1"),)


@pytest.mark.parametrize("word", ["-s", "--show-args", "--show-arguments"])
def test_a_launch_may_list_arguments(launched, word, folder):
    line = [word, F, "--evaluation-timeout=3", "--restart=x=always", "a:=1"]
    assert launched(launch, line) == ("args", str(folder / F), 3.0)


@pytest.mark.parametrize("word", ["-p", "--print", "--print-description"])
def test_a_launch_may_show_the_plan(launched, word):
    verb, arguments, *_, wall_s = launched(launch, [F, word, "a:=1", "--evaluation-timeout", "0"])
    assert (verb, arguments, wall_s) == ("plan", {"a": "1"}, 0.0)


@pytest.mark.parametrize(
    ("line", "flags"),
    [
        (f"{F} a:=1", set()),
        (f"--json {F} --lenient a:=1", {"--json", "--lenient"}),
        (f"{F} --debug a:=1 -d", set()),
        (f"{F} --json -- a:=1", {"--json"}),
    ],
)
def test_words_of_a_plan(launched, line, flags):
    verb, arguments, options, _, wall_s = launched(plan, line.split())
    assert (verb, arguments, wall_s) == ("plan", {"a": "1"}, 60.0)
    assert {f"--{name}" for name in options} == flags


def test_words_of_args(launched, folder):
    for line in (F, f"-d {F}", f"{F} --debug", f"-- {F}"):
        assert launched(args, line.split()) == ("args", str(folder / F), 60.0)
    line = ["--evaluation-timeout", "5", F]
    assert launched(args, line) == ("args", str(folder / F), 5.0)


@pytest.mark.parametrize(
    "line",
    [
        "",
        "--lenient",
        f"{F} --bogus",
        f"{F} --lenient=1",
        f"{F} --ros=1",
        f"{F} --timeout",
        f"{F} --timeout soon",
        f"{F} --timeout=inf",
        f"{F} --stagger -1",
        f"{F} --max-starting 0",
        f"{F} --max-starting=²",
        f"{F} --restart x",
        f"{F} --restart=",
        f"{F} --evaluation-timeout -1",
        f"{F} --evaluation-timeout nan",
        f"{F} --evaluation-timeout",
        f"{F} --launch-prefix-filter x",
        f"{F} --ros --no-control",
        f"{F} --json",
        f"{F} --budgets gone.yaml",
        f"{F} b",
        "gone.launch.py",
    ],
)
def test_words_that_no_launch_takes(line):
    with pytest.raises(LauncherError) as caught:
        launch.main(line.split())
    assert caught.value.exit_code == 2


# ---- run


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("p e", ["/e"]),
        ("--debug p e", ["/e"]),
        ("p e --ros-args -r a:=b -h --debug", ["/e", "--ros-args", "-r", "a:=b", "-h", "--debug"]),
        ("p e -- -x", ["/e", "-x"]),
        ("p e a -- b", ["/e", "a", "--", "b"]),
        ("p e -- -- b", ["/e", "--", "b"]),
    ],
)
def test_words_of_run(monkeypatch, line, expected):
    seen: list[Any] = []
    monkeypatch.setattr(run, "find_executable", lambda package, name, env: Path(f"/{name}"))
    monkeypatch.setattr(run, "_become", seen.append)
    run.main(line.split())
    assert seen == [expected]


@pytest.mark.parametrize("line", ["", "--bogus p e", "/p e", "../p e", "p ../e", "p /e"])
def test_words_that_run_does_not_take(line):
    with pytest.raises(LauncherError) as caught:
        run.main(line.split())
    assert caught.value.exit_code == 2


# ---- verbs about a run


def called(line: str) -> tuple[tuple[str, ...], dict[str, Any], str | None, bool]:
    name, *words = shlex.split(line)
    verb = verbs.find(name)
    assert verb is not None
    parsed = control.command_of(verb).parse(words)
    call = verbs.call_of(verb, parsed)
    assert call.verb is verb
    return call.names, dict(call.options), parsed.run, parsed.json


@pytest.mark.parametrize(
    ("line", "names", "options", "run", "as_json"),
    [
        ("ps", (), {}, None, False),
        ("ps a --run 1 b --json", ("a", "b"), {}, "1", True),
        ("ps --run=1 --debug -- --json -x", ("--json", "-x"), {}, "1", False),
        ("ps --run -x", (), {}, "-x", False),
        ("ps -", ("-",), {}, None, False),
        ("kill a b -s TERM", ("a", "b"), {"signal": 15}, None, False),
        ("kill -9 a", ("a",), {"signal": 9}, None, False),
        ("kill a -KILL --json", ("a",), {"signal": 9}, None, True),
        ("kill a --signal=int", ("a",), {"signal": 2}, None, False),
        ("kill a -s 0", ("a",), {"signal": 0}, None, False),
        ("kill a -s=INT", ("a",), {"signal": 2}, None, False),
        ("top -p 0.5 -f", (), {"period_s": 0.5, "follow": True}, None, False),
        ("top --period=2 a", ("a",), {"period_s": 2.0}, None, False),
        ("logs -n 5 --follow a", ("a",), {"lines": 5, "follow": True}, None, False),
        ("logs a --lines 0", ("a",), {"lines": 0}, None, False),
        ("level", (), {}, None, False),
        ("level WARN a", ("a",), {"level": "WARN"}, None, False),
        ("grep -- -x a", ("a",), {"pattern": "-x"}, None, False),
        ("grep 'a b'", (), {"pattern": "a b"}, None, False),
        ("send a some  text", ("a",), {"text": "some text"}, None, False),
        ("send a -5 --json -n", ("a",), {"text": "-5 -n"}, None, True),
        ("send --run 1 a x", ("a",), {"text": "x"}, "1", False),
        ("send a -- --json", ("a",), {"text": "--json"}, None, False),
        ("send a x -- -- y", ("a",), {"text": "x -- y"}, None, False),
        ("events -f --new", (), {"follow": True, "history": False}, None, False),
        ("quit --json", (), {}, None, True),
    ],
)
def test_words_about_a_run(line, names, options, run, as_json):
    assert called(line) == (names, options, run, as_json)


@pytest.mark.parametrize(
    "line",
    [
        "ps --run",
        "ps --run=",
        "ps --run --json",
        "ps -x",
        "ps --bogus",
        "ps --json=1",
        "kill",
        "kill a -s",
        "kill a -99",
        "kill a -s NO",
        "quit now",
        "top -p 0",
        "top -p nan",
        "send a",
        "logs -n -1",
        "logs --follow=1",
        "send a x --bogus",
        "runs x",
        "events a",
    ],
)
def test_words_that_no_verb_about_a_run_takes(line):
    with pytest.raises(UsageError):
        control.main(line.split())


# ---- smoke


@pytest.fixture
def smoked(monkeypatch) -> Any:
    """What `smoke WORDS` would run: (script, options, words for the launcher)."""
    seen: list[Any] = []
    from launcher.smoke.run.session import Session

    def note(session: Any) -> int:
        seen.append(session)
        return 0

    monkeypatch.setattr(Session, "run", note)
    monkeypatch.setattr(smoke, "_check", lambda script, words: None)

    def read(line: str) -> tuple[Any, Any, list[str]]:
        assert smoke.main(shlex.split(line)) == 0
        session = seen.pop()
        options = session._options
        return session._script, options, list(options.words)

    return read


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (F, [F]),
        (f"{F} a:=1 --for 3 --nice x=1", [F, "a:=1", "--nice", "x=1"]),
        (f"--lenient {F} -n --github --timeout=3", ["--lenient", F, "-n", "--timeout=3"]),
        (f"{F} --launch-prefix x --repeat 2", [F, "--launch-prefix", "x"]),
        (f"{F} --evaluation-timeout=9 --debug", [F, "--evaluation-timeout=9", "--debug"]),
        (f"{F} -d --no-file", [F, "-d"]),
    ],
)
def test_words_that_smoke_hands_on(smoked, line, words):
    assert smoked(line)[2] == words


@pytest.mark.parametrize(
    ("line", "script"),
    [
        ("--for 3", {"for_s": 3.0}),
        ("--for=1min", {"for_s": 60.0}),
        ("--ready-within 9s --for 1 --for 2", {"ready_within_s": 9.0, "for_s": 2.0}),
    ],
)
def test_times_of_smoke(smoked, line, script):
    found = smoked(f"{F} {line}")[0]
    assert {name: getattr(found, name) for name in script} == script


@pytest.mark.parametrize(
    ("line", "options"),
    [
        ("--github --repeat 3", {"github": True, "repeat": 3}),
        ("--junit=j.xml", {"junit": Path("j.xml")}),
        (
            "--baseline b.json --update-baseline",
            {"baseline": Path("b.json"), "update_baseline": True},
        ),
        ("--artifacts evidence", {"artifacts": Path("evidence")}),
    ],
)
def test_options_of_smoke(smoked, line, options):
    found = smoked(f"{F} {line}")[1]
    assert {name: getattr(found, name) for name in options} == options


@pytest.mark.parametrize(
    ("line", "kinds"),
    [
        ("--expect-node /a=8s --expect-topic=/t", ["node", "topic"]),
        ("--expect e.yaml --expect-node /a", ["node", "node"]),
        (
            "--no-errors --no-tracebacks=x --clean-shared-memory",
            ["no_errors", "no_tracebacks", "shared_memory"],
        ),
        ("--no-errors=robot_*", ["no_errors"]),
        ("--expect-publishers /a=1 --expect-subscriptions=/a=2", ["topic", "topic"]),
        ("--expect-qos /a=reliability:reliable --expect-rate '/a=1 Hz ± 20 %'", ["qos", "rate"]),
        ("--expect-message /a --expect-all '/a=m.x > 1'", ["message", "message"]),
        ("--expect-log 'a: b' --forbid-log Traceback", ["log", "log"]),
        ("--expect-alive a --expect-exit b=0", ["process", "process"]),
        ("--expect-parameter /a:p=1 --expect-service /s", ["parameter", "service"]),
        ("--max-cpu a=80% --max-memory=a=1MB", ["cpu", "memory"]),
        ("--max-start-up 3 --max-shutdown=4s", ["start_up", "clean_shutdown"]),
    ],
)
def test_expectations_of_smoke(smoked, line, kinds):
    assert [one.kind for one in smoked(f"{F} {line}")[0].expectations] == kinds


def test_chaos_of_smoke(smoked):
    chaos = smoked(f"{F} --chaos 'kill one of x every 5 s' --seed 7")[0].chaos
    assert (chaos.seed, chaos.every_s) == (7, 5.0)


@pytest.mark.parametrize(
    "line",
    [
        "--for",
        "--for soon",
        "--repeat 0",
        "--repeat x",
        "--expect a --expect b",
        "--seed 3",
        "--expec e.yaml",
        "--bogus",
        "--no-file=1",
        "--junit=",
        "--expect-node",
        "--chaos x",
        "--expect-rate /a",
        "--json",
        "--show-args",
        "--timeout x",
        "--clean-shared-memory x",
    ],
)
def test_words_that_smoke_does_not_take(line):
    with pytest.raises(LauncherError) as caught:
        smoke.main([F, *line.split()])
    assert caught.value.exit_code == 2


# ---- doctor


@pytest.mark.parametrize(
    ("line", "repairs", "as_json"),
    [("", 0, False), ("--fix", 1, False), ("--json --debug", 0, True), ("--json --fix", 1, True)],
)
def test_words_of_doctor(monkeypatch, capsys, line, repairs, as_json):
    done: list[Any] = []
    monkeypatch.setattr(doctor, "collect", lambda environment: "facts")
    monkeypatch.setattr(doctor, "repair", lambda facts: done.append(facts) or [])
    monkeypatch.setattr(doctor, "check_all", lambda facts: [])
    monkeypatch.setattr(doctor, "as_text", lambda findings, done: "text")
    assert doctor.main(line.split()) == 0
    assert len(done) == repairs
    assert capsys.readouterr().out.startswith("{" if as_json else "text")


@pytest.mark.parametrize("line", ["--fixx", "x", "--fix=1"])
def test_words_that_doctor_does_not_take(line):
    with pytest.raises(UsageError):
        doctor.main(line.split())


# ---- ROS verbs


def understood(verb: str, words: list[str]) -> tuple[str, dict[str, Any]]:
    """(the verb below, its options) that a ROS verb makes of its words."""
    module = importlib.import_module(f"launcher.commands.{verb}")
    options = vars(module.COMMAND.parse(words))
    return options["command"].name.rpartition(" ")[2], options


BASE = {"domain": None, "spin_time": None, "json": False, "no_observer": False}
QOS = dict.fromkeys(
    [
        "qos_profile",
        "qos_depth",
        "qos_reliability",
        "qos_durability",
        "qos_liveliness",
        "qos_history",
        "qos_liveliness_lease_duration_seconds",
    ]
)
ECHO = {
    **BASE,
    **QOS,
    "once": False,
    "timeout": None,
    "field": None,
    "filter": None,
    "csv": False,
    "full_length": False,
    "truncate_length": 128,
    "no_arr": False,
    "no_str": False,
    "flow_style": False,
    "raw": False,
    "include_message_info": False,
}
HZ = {**BASE, **QOS, "window": 10000, "filter": None, "for_s": None, "min_hz": None}
BW = {**BASE, **QOS, "window": 100, "for_s": None}
PUB = {
    **BASE,
    **QOS,
    "values": "",
    "stdin": False,
    "rate": 1.0,
    "print": 1,
    "once": False,
    "times": None,
    "wait_matching_subscriptions": None,
    "keep_alive": 0.1,
}
GRAPH = {
    **BASE,
    "mode": "all",
    "include": None,
    "exclude": None,
    "debug_topics": False,
    "hidden": False,
    "dot": False,
    "mermaid": False,
    "svg": None,
    "html": None,
    "watch": False,
    "diff": None,
    "period": 0.5,
}
LISTED = {**BASE, "show_types": False, "include_hidden_topics": False, "count_topics": False}
LISTED["verbose"] = False
INFO = {**BASE, "verbose": False, "explain": False}
NODE = {**BASE, "node_name": "/n", "include_hidden_nodes": False}
PARAMS = {**NODE, "param_prefixes": (), "param_type": False}
CALL = {**BASE, "values": "", "stdin": False, "rate": None, "timeout": 30.0}
SERVICES = {**BASE, "show_types": False, "count_services": False}
SERVICES["include_hidden_services"] = False
TYPES = {**BASE, "only_msgs": False, "only_srvs": False, "only_actions": False}
SHOW = {**BASE, "type": "T", "all_comments": False, "no_comments": False}


@pytest.mark.parametrize(
    ("line", "base", "changes"),
    [
        ("topic list", LISTED, {}),
        (
            "topic list -t -v -c",
            LISTED,
            {"show_types": True, "verbose": True, "count_topics": True},
        ),
        ("topic list -tv", LISTED, {"show_types": True, "verbose": True}),
        ("topic list --include-hidden-topics", LISTED, {"include_hidden_topics": True}),
        ("topic list --include", LISTED, {"include_hidden_topics": True}),
        (
            "topic list -d 5 --spin-time 2 --json",
            LISTED,
            {"domain": "5", "spin_time": 2.0, "json": True},
        ),
        ("topic list -d5 --spin-time=.5", LISTED, {"domain": "5", "spin_time": 0.5}),
        (
            "topic list --domain=7 --no-observer --no-daemon",
            LISTED,
            {"domain": "7", "no_observer": True},
        ),
        ("topic info /t -v", INFO, {"topic_name": "/t", "verbose": True}),
        ("topic info --explain -- /t", INFO, {"topic_name": "/t", "explain": True}),
        ("topic echo /t", ECHO, {"words": ["/t"]}),
        (
            "topic echo --once /t std_msgs/String",
            ECHO,
            {"words": ["/t", "std_msgs/String"], "once": True},
        ),
        (
            "topic echo /a /b --csv -f",
            ECHO,
            {"words": ["/a", "/b"], "csv": True, "full_length": True},
        ),
        ("topic echo /a -l 5 --raw", ECHO, {"words": ["/a"], "truncate_length": 5, "raw": True}),
        (
            "topic echo /a -l5 -i",
            ECHO,
            {"words": ["/a"], "truncate_length": 5, "include_message_info": True},
        ),
        (
            "topic echo /a --timeout 3 --field x.y[0]",
            ECHO,
            {"words": ["/a"], "timeout": 3.0, "field": "x.y[0]"},
        ),
        ("topic echo /a --filter 'm.x > 1'", ECHO, {"words": ["/a"], "filter": "m.x > 1"}),
        (
            "topic echo /a --no-arr --no-str --flow-style",
            ECHO,
            {"words": ["/a"], "no_arr": True, "no_str": True, "flow_style": True},
        ),
        ("topic echo /a --no-lost-messages", ECHO, {"words": ["/a"]}),
        (
            "topic echo /a --qos-profile sensor_data --qos-depth 3",
            ECHO,
            {"words": ["/a"], "qos_profile": "sensor_data", "qos_depth": 3},
        ),
        (
            "topic echo /a --qos-reliability best_effort --qos-durability=volatile",
            ECHO,
            {"words": ["/a"], "qos_reliability": "best_effort", "qos_durability": "volatile"},
        ),
        (
            "topic echo /a --qos-history keep_all --qos-liveliness automatic",
            ECHO,
            {"words": ["/a"], "qos_history": "keep_all", "qos_liveliness": "automatic"},
        ),
        (
            "topic echo /a --qos-liveliness-lease-duration-seconds 2",
            ECHO,
            {"words": ["/a"], "qos_liveliness_lease_duration_seconds": 2.0},
        ),
        ("topic hz /a /b -w 4", HZ, {"topic_names": ["/a", "/b"], "window": 4}),
        (
            "topic hz /a --for 3 --min 2.5 --wall-time",
            HZ,
            {"topic_names": ["/a"], "for_s": 3.0, "min_hz": 2.5},
        ),
        ("topic hz /a --filter m.x", HZ, {"topic_names": ["/a"], "filter": "m.x"}),
        ("topic bw /a --window=3 --for=1", BW, {"topic_name": "/a", "window": 3, "for_s": 1.0}),
        ("topic delay /a", BW, {"topic_name": "/a", "window": 10000}),
        ("topic pub /a T", PUB, {"topic_name": "/a", "message_type": "T"}),
        (
            "topic pub /a T 'data: 1' -1",
            PUB,
            {"topic_name": "/a", "message_type": "T", "values": "data: 1", "once": True},
        ),
        (
            "topic pub --once /a T 'data: 1'",
            PUB,
            {"topic_name": "/a", "message_type": "T", "values": "data: 1", "once": True},
        ),
        (
            "topic pub /a T '- a b'",
            PUB,
            {"topic_name": "/a", "message_type": "T", "values": "- a b"},
        ),
        (
            "topic pub /a T --stdin -r 5 -p 2 -t 3",
            PUB,
            {
                "topic_name": "/a",
                "message_type": "T",
                "stdin": True,
                "rate": 5.0,
                "print": 2,
                "times": 3,
            },
        ),
        (
            "topic pub /a T -r10 -w 0 --keep-alive 0",
            PUB,
            {
                "topic_name": "/a",
                "message_type": "T",
                "rate": 10.0,
                "wait_matching_subscriptions": 0,
                "keep_alive": 0.0,
            },
        ),
        ("topic type /a", BASE, {"topic_name": "/a"}),
        (
            "topic find T -c --include-hidden-topics",
            BASE,
            {"topic_type": "T", "count_topics": True, "include_hidden_topics": True},
        ),
        ("node list -a -c", BASE, {"all": True, "count_nodes": True}),
        ("node list -ac", BASE, {"all": True, "count_nodes": True}),
        ("node info /n --include-hidden", BASE, {"node_name": "/n", "include_hidden": True}),
        ("node ps --all --answer-timeout 2", BASE, {"all": True, "answer_timeout": 2.0}),
        ("node ps", BASE, {"all": False, "answer_timeout": 1.0}),
        ("param list", PARAMS, {"node_name": None}),
        ("param list /n --param-type", PARAMS, {"param_type": True}),
        ("param list /n --param-prefixes a b", PARAMS, {"param_prefixes": ["a", "b"]}),
        ("param list --param-prefixes a b -- /n", PARAMS, {"param_prefixes": ["a", "b"]}),
        (
            "param list --param-prefixes a b --json /n",
            PARAMS,
            {"param_prefixes": ["a", "b"], "json": True},
        ),
        ("param list --param-prefixes=a /n", PARAMS, {"param_prefixes": ["a"]}),
        ("param get /n p --hide-type", NODE, {"parameter_name": "p", "hide_type": True}),
        ("param set /n p 1 q 2 --atomic", NODE, {"pairs": ["p", "1", "q", "2"], "atomic": True}),
        ("param set /n p -5", NODE, {"pairs": ["p", "-5"], "atomic": False}),
        ("param set /n p -1.5", NODE, {"pairs": ["p", "-1.5"], "atomic": False}),
        ("param set /n p -- -x", NODE, {"pairs": ["p", "-x"], "atomic": False}),
        (
            "param describe /n p q --include-hidden-nodes",
            NODE,
            {"parameter_names": ["p", "q"], "include_hidden_nodes": True},
        ),
        ("param dump /n", NODE, {}),
        (
            "param load /n f.yaml --use-wildcard",
            NODE,
            {"parameter_file": "f.yaml", "use_wildcard": True},
        ),
        ("service list -t -c", SERVICES, {"show_types": True, "count_services": True}),
        ("service type /s", BASE, {"service_name": "/s"}),
        (
            "service find T -c",
            BASE,
            {"service_type": "T", "count_services": True, "include_hidden_services": False},
        ),
        ("service call /s T", CALL, {"service_name": "/s", "service_type": "T"}),
        (
            "service call /s T '{a: 1}' -r 2 --timeout 3",
            CALL,
            {
                "service_name": "/s",
                "service_type": "T",
                "values": "{a: 1}",
                "rate": 2.0,
                "timeout": 3.0,
            },
        ),
        (
            "service call --stdin /s T",
            CALL,
            {"service_name": "/s", "service_type": "T", "stdin": True},
        ),
        ("interface list -m -s", TYPES, {"only_msgs": True, "only_srvs": True}),
        ("interface list -a", TYPES, {"only_actions": True}),
        ("interface show T --all-comments", SHOW, {"all_comments": True}),
        ("interface show -", SHOW, {"type": "-"}),
        ("interface show T --no-comments", SHOW, {"no_comments": True}),
        ("interface proto T --no-quotes", BASE, {"type": "T", "no_quotes": True}),
        ("graph", GRAPH, {}),
        ("graph --dot --mode nodes", GRAPH, {"dot": True, "mode": "nodes"}),
        (
            "graph --mermaid --include a --exclude=b",
            GRAPH,
            {"mermaid": True, "include": "a", "exclude": "b"},
        ),
        (
            "graph --svg f.svg --debug-topics --hidden",
            GRAPH,
            {"svg": "f.svg", "debug_topics": True, "hidden": True},
        ),
        ("graph --html=f.html", GRAPH, {"html": "f.html"}),
        ("graph --watch --period 2", GRAPH, {"watch": True, "period": 2.0}),
        ("graph --diff f.json --json -d 3", GRAPH, {"diff": "f.json", "json": True, "domain": "3"}),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_words_of_a_ros_verb(line, base, changes):
    verb, *words = shlex.split(line)
    sub, options = understood(verb, words)
    assert sub == ("graph" if verb == "graph" else words[0])
    expected = {**base, **changes}
    assert {name: options[name] for name in expected} == expected


@pytest.mark.parametrize(
    "line",
    [
        "topic bogus",
        "topic list x",
        "topic list --bogus",
        "topic list --json=1",
        "topic info",
        "topic info a b",
        "topic echo",
        "topic echo /a --timeout",
        "topic echo /a --timeout x",
        "topic echo /a --qos-durability eternal",
        "topic echo /a --qos-depth 0",
        "topic hz /a -w 0",
        "topic pub /a",
        "topic pub /a T --once -t 3",
        "topic pub /a T --rate x",
        "node info",
        "topic list --spin-time -1",
        "topic list --spin-time nan",
        "topic list -z",
        "param get /n",
        "param set /n",
        "service call /s",
        "interface show T --all-comments --no-comments",
        "graph x",
        "graph --dot --svg f",
        "graph --mode some",
        "graph --svg",
        "topic echo /a -l ²",
    ],
)
def test_words_that_no_ros_verb_takes(line):
    verb, *words = line.split()
    with pytest.raises(UsageError):
        importlib.import_module(f"launcher.commands.{verb}").main(words)


@pytest.mark.parametrize("verb", ["topic", "node", "param", "service", "interface"])
def test_a_ros_verb_alone_prints_its_help(verb, capsys):
    assert cli.main([verb]) == 2
    assert capsys.readouterr().out.startswith(f"usage: python -m launcher {verb}")
