"""How `smoke` parses its arguments; these command lines must keep their meaning."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import pytest

from launcher.base.errors import LauncherError
from launcher.smoke import verb as smoke
from launcher.smoke.preflight import loader

pytestmark = pytest.mark.usefixtures("command_folder")

F = "a.launch.py"


@pytest.fixture
def smoked(monkeypatch) -> Any:
    """What `smoke WORDS` would run: (script, options, words for the launcher)."""
    seen: list[Any] = []
    from launcher.smoke.run.smoke_session import Session

    def note(session: Any) -> int:
        seen.append(session)
        return 0

    monkeypatch.setattr(Session, "run", note)
    monkeypatch.setattr(smoke, "_check", lambda script: None)

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
            "--expect-no-errors --expect-no-tracebacks=x --expect-shared-memory",
            ["no_errors", "no_tracebacks", "shared_memory"],
        ),
        ("--expect-no-errors=robot_*", ["no_errors"]),
        ("--expect-topic-publishers /a=1 --expect-topic-subscriptions=/a=2", ["topic", "topic"]),
        (
            "--expect-qos-publishers /a=reliability:reliable --expect-rate '/a=1 Hz ± 20 %'",
            ["qos", "rate"],
        ),
        ("--expect-message /a --expect-message-all '/a=m.x > 1'", ["message", "message"]),
        ("--expect-log 'a: b' --expect-log-count Traceback=0", ["log", "log"]),
        ("--expect-process a --expect-process b=0 --expect-process-restarts b=1", ["process"] * 3),
        ("--expect-parameter /a:p=1 --expect-service /s", ["parameter", "service"]),
        ("--expect-cpu a=80% --expect-memory=a=1MB", ["cpu", "memory"]),
        ("--expect-start-up 3 --expect-clean-shutdown=4s", ["start_up", "clean_shutdown"]),
    ],
)
def test_expectations_of_smoke(smoked, line, kinds):
    assert [one.kind for one in smoked(f"{F} {line}")[0].expectations] == kinds


@pytest.mark.parametrize(
    ("line", "workflow", "on"),
    [
        ("", "", False),
        ("", "true", True),
        ("--github", "", True),
        ("--no-github", "true", False),
        ("", "false", False),
    ],
)
def test_github_is_on_by_itself_in_a_workflow(smoked, monkeypatch, line, workflow, on):
    monkeypatch.setenv("GITHUB_ACTIONS", workflow)
    assert smoked(f"{F} {line}")[1].github is on


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
        "--expect-log",
        "--github --no-github",
        "--chaos x",
        "--expect-rate /a",
        "--json",
        "--show-args",
        "--timeout x",
        "--expect-shared-memory x",
    ],
)
def test_words_that_smoke_does_not_take(line):
    with pytest.raises(LauncherError) as caught:
        smoke.main([F, *line.split()])
    assert caught.value.exit_code == 2


NONE = "smoke: no expectations{}, except that no process exits unexpectedly\n"


@pytest.mark.parametrize(
    ("line", "where"),
    [
        (F, " (there is no {}/a.expect.yaml)"),
        (f"{F} --no-file", ""),
        (f"{F} --expect-node /a", None),
    ],
)
def test_without_expectations_the_place_where_they_belong_is_named(smoked, capsys, line, where):
    smoked(line)
    message = "" if where is None else NONE.format(where.format(Path.cwd()))
    assert capsys.readouterr().err == message


@pytest.mark.parametrize("name", ["system.launch.py", "system_launch.xml", "system.py"])
def test_the_file_beside_a_launch_file_has_its_name(tmp_path: Path, name: str):
    assert loader.usual(str(tmp_path / name)) == tmp_path / "system.expect.yaml"
