"""How launching, verbs about a run, and `doctor` parse their arguments.

These command lines must keep their meaning.
"""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import Any

import pytest

from launcher.base.errors import LauncherError, UsageError
from launcher.base.model.run_options import RunOptions
from launcher.base.model.spec import RestartMode
from launcher.control import verb as control
from launcher.control import verbs
from launcher.doctor import verb as doctor
from launcher.launch.verbs import args, launch, plan, run

pytestmark = pytest.mark.usefixtures("command_folder")


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

    def planned(
        request: Any,
        *,
        as_json: bool = False,
        target: str | None = None,
        options: RunOptions,
    ) -> int:
        note("plan", request)
        if target is not None:
            seen[-1][2].add(f"target={target}")
        seen[-1][2].update(f"level={pattern}" for pattern, _ in options.log_levels)
        if as_json:
            seen[-1][2].add("json")
        if options.hosts is not None:
            seen[-1][2].add(f"hosts={options.hosts}")
        if options.discovery is not None:
            seen[-1][2].add(f"discovery={options.discovery}")
        if options.skip_hosts:
            seen[-1][2].add(f"skip={','.join(options.skip_hosts)}")
        for pattern, words in options.prefix:
            seen[-1][2].add(f"prefix={pattern}={','.join(words)}")
        return 0

    monkeypatch.setattr(
        launch, "launch", lambda request, options, _: note("launch", request, options)
    )
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
        (f"{F} --responsive", {}, {}, {"responsive": True}),
        (f"--timeout 2.5 {F}", {}, {}, {"timeout_s": 2.5}),
        (f"--timeout=1 {F} --timeout=0.5", {}, {}, {"timeout_s": 0.5}),
        (f"{F} --stagger .5 --max-starting 3", {}, {}, {"stagger_s": 0.5, "max_starting": 3}),
        (f"{F} --required a --required=b*", {}, {}, {"required": ("a", "b*")}),
        (f"{F} --budget x:fds=9 --budget=y:cpu=1", {}, {}, {"budgets": ("x:fds=9", "y:cpu=1")}),
        (
            f"{F} --prefix 'x=sh -c \"a b\"' --prefix=y=nice",
            {},
            {},
            {"prefix": (("x", ("sh", "-c", "a b")), ("y", ("nice",)))},
        ),
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
    assert [budget.fds for budget in run_options["file_budgets"]] == [9]
    assert run_options["file_names"] == (("x", "budgets.yaml:1"),)


@pytest.mark.parametrize("word", ["-s", "--show-args", "--show-arguments"])
def test_a_launch_may_list_arguments(launched, word, command_folder):
    line = [word, F, "--evaluation-timeout=3", "--restart=x=always", "a:=1"]
    assert launched(launch, line) == ("args", str(command_folder / F), 3.0)


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
        (f"--log-level a=debug,b=info {F} a:=1", {"--level=a", "--level=b"}),
        (
            f"{F} a:=1 --hosts h.yaml --discovery peers --skip-host b1 --skip-host=c*",
            {"--hosts=h.yaml", "--discovery=peers", "--skip=b1,c*"},
        ),
        (f"{F} a:=1 --prefix=b=nice", {"--prefix=b=nice"}),
        (f"--target kilted {F} a:=1", {"--target=kilted"}),
    ],
)
def test_words_of_a_plan(launched, line, flags):
    verb, arguments, options, _, wall_s = launched(plan, line.split())
    assert (verb, arguments, wall_s) == ("plan", {"a": "1"}, 60.0)
    assert {f"--{name}" for name in options} == flags


def test_words_of_args(launched, command_folder):
    for line in (F, f"-d {F}", f"{F} --debug", f"-- {F}"):
        assert launched(args, line.split()) == ("args", str(command_folder / F), 60.0)
    line = ["--evaluation-timeout", "5", F]
    assert launched(args, line) == ("args", str(command_folder / F), 5.0)


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
        f"{F} --skip-host bot1",
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
        ("--prefix 'gdb -ex run --args' p e a", ["gdb", "-ex", "run", "--args", "/e", "a"]),
        ("p e --prefix nice", ["/e", "--prefix", "nice"]),
    ],
)
def test_words_of_run(monkeypatch, line, expected):
    seen: list[Any] = []
    monkeypatch.setattr(run, "find_executable", lambda package, name, env: Path(f"/{name}"))
    monkeypatch.setattr(run, "_become", seen.append)
    run.main(shlex.split(line))
    assert seen == [expected]


@pytest.mark.parametrize(
    "line",
    [
        "",
        "--bogus p e",
        "/p e",
        "../p e",
        "p ../e",
        "p /e",
        "--prefix '' p e",
        "--prefix '\"' p e",
        "--prefix /no/such/command p e",
    ],
)
def test_words_that_run_does_not_take(monkeypatch, line):
    monkeypatch.setattr(run, "find_executable", lambda package, name, env: Path(f"/{name}"))
    with pytest.raises(LauncherError) as caught:
        run.main(shlex.split(line))
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


# ---- doctor


@pytest.mark.parametrize(
    ("line", "repairs", "as_json"),
    [("", 0, False), ("--fix", 1, False), ("--json --debug", 0, True), ("--json --fix", 1, True)],
)
def test_words_of_doctor(monkeypatch, capsys, line, repairs, as_json):
    done: list[Any] = []
    monkeypatch.setattr(doctor, "collect", lambda environment, workspace: "facts")
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
