"""Verbs that filter, follow or describe a run's output, on real processes."""

from __future__ import annotations

import json
import re
import subprocess

import pytest

from launcher.control.client import RefusedError
from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun
from tests.support.waiting import wait_until

CAT = 'sh("exec cat", name="cat")'
SLEEPER = 'sh("exec sleep 1000", name="sleeper")'


def test_a_muted_process_is_not_shown_but_kept_and_counted(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        run.ask_text("mute", "cat")
        run.ask_text("send", "cat", text="hidden")
        run.wait_for_log("cat", "hidden")
        assert run.row("cat")["muted"]
        assert run.row("cat")["hidden_lines"] == 1
        assert run.ask_text("unmute") == "cat-1 is shown again; 1 line was not shown"
        run.ask_text("send", "cat", text="visible")
        run.wait_for("[cat-1] visible\n")
        assert "hidden" not in run.screen
        assert "[cat-1] hidden\n" in run.log


def test_what_a_muted_process_leaves_unfinished_is_not_shown_either(control_bench: ControlBench):
    written = control_bench.folder / "written"
    ends = f"printf ' and ended'; : > {written}; exec sleep 1000"
    script = f"printf begun; read line; {ends}"
    with control_bench.launch(f'sh("{script}", name="prompt"), {CAT}') as run:
        run.wait_for("begun")
        run.ask_text("mute", "prompt")
        run.ask_text("send", "prompt", text="x")
        wait_until(written.exists, "all of it")
        run.ask_text("kill", "prompt", signal="KILL")
        run.ask_text("send", "cat", text="then")
        run.wait_for("[cat-2] then\n")
        assert "and ended" not in run.screen
        wait_until(lambda: "begun and ended" in run.log, "it in the log")


def test_one_process_is_shown_alone(control_bench: ControlBench):
    other = 'sh("exec cat", name="other")'
    with control_bench.launch(f"{CAT}, {other}") as run:
        assert "cat-1 is shown alone" in run.ask_text("solo", "cat")
        for name in ("other", "cat"):
            run.ask_text("send", name, text=f"from {name} alone")
            run.wait_for_log(name, "alone")
        run.ask_text("unmute")
        run.ask_text("send", "other", text="from other again")
        run.wait_for("[other-2] from other again\n")
        assert "from cat alone" in run.screen
        assert "from other alone" not in run.screen


def test_only_warnings_are_shown_and_later_everything(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        run.ask_text("level", level="WARN")
        for line in ("[INFO] [1.0] [n]: idle", "[WARN] [1.0] [n]: battery", "plain"):
            run.ask_text("send", "cat", text=line)
        run.wait_for("[cat-1] [WARN] [1.0] [n]: battery\n")
        run.wait_for_log("cat", "plain")
        assert run.row("cat")["level"] == "WARN"
        run.ask_text("level", "cat", level="all")
        run.ask_text("send", "cat", text="[DEBUG] [1.0] [n]: seen")
        run.wait_for("seen")
        assert "idle" not in run.screen
        assert "plain" not in run.screen


def test_only_lines_with_a_pattern_are_shown(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        run.ask_text("grep", pattern=r"task \d")
        for line in ("nothing", "task 7"):
            run.ask_text("send", "cat", text=line)
        run.wait_for("[cat-1] task 7\n")
        assert "nothing" not in run.screen
        with pytest.raises(RefusedError, match="invalid pattern") as refused:
            run.ask_text("grep", pattern="(")
        assert refused.value.code == "bad-option"


def test_a_pattern_that_takes_for_ever_does_not_hold_up_the_run(control_bench: ControlBench):
    other = 'sh("exec cat", name="other")'
    with control_bench.launch(f"{CAT}, {other}") as run:
        run.ask_text("grep", pattern="(a+)+$")
        run.ask_text("send", "cat", text="a" * 60 + "!")
        run.wait_for("matching '(a+)+$' takes too long; every line is shown again")
        run.ask_text("send", "other", text="a line")
        run.wait_for("[other-2] a line\n")
        assert run.row("other")["grep"] is None


def test_logs_are_followed_whatever_is_shown_and_without_any_files(control_bench: ControlBench):
    with control_bench.launch(CAT, "--no-log-files") as run:
        run.ask_text("mute", "cat")
        run.ask_text("send", "cat", text="before")
        run.wait_for_log("cat", "before")
        with run.connect() as connection:
            items = connection.follow("logs", ["cat"], lines=10)
            assert next(items)["text"] == "before"
            run.ask_text("send", "cat", text="after")
            item = next(items)
            assert item["text"] == "after"
            assert item["process"] == "cat-1"
            assert item["stream"] == "both"


def test_all_lines_with_those_of_the_launcher_are_in_the_order_of_time(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        run.ask_text("send", "cat", text="a line")
        run.wait_for_log("cat", "a line")
        lines = run.ask("logs", lines=50)["lines"]
        texts = [line["text"] for line in lines]
        assert lines[0]["process"] is None
        started = next(text for text in texts if "process started" in text)
        assert texts.index(started) < texts.index("a line")
        assert [line["wall_s"] for line in lines] == sorted(line["wall_s"] for line in lines)


def test_events_are_followed_from_the_first_to_the_last(control_bench: ControlBench):
    with control_bench.launch(SLEEPER) as run, run.connect() as connection:
        entries = connection.follow("events")
        assert next(entries)["event"] == "started"
        run.ask_text("kill", "sleeper", signal="TERM")
        wait_until(lambda: run.row("sleeper")["pid"] is None, "its end")
        run.ask_text("quit")
        # To the end of the run; samples are taken as time goes by.
        rest = [entry for entry in entries if entry["event"] != "resources"]
        names = [entry["event"] for entry in rest]
        assert names == ["asked", "signal", "ended", "asked", "stopping", "finished"]
        folder = connection.hello["run"]["log_dir"]
        with open(f"{folder}/events.jsonl", encoding="utf-8") as file:
            written = [json.loads(line) for line in file]
        assert [entry for entry in written if entry["event"] != "resources"][1:] == rest
        assert run.exit_code() == 0


def test_info_shows_command_environment_and_policy(control_bench: ControlBench):
    action = 'sh("exec sleep 1000", name="it", additional_env={"MOOD": "good"}, respawn=True)'
    with control_bench.launch(action) as run:
        (info,) = run.ask("info", "it")["processes"]
        assert info["cmd"] == ["sh", "-c", "exec sleep 1000"]
        assert info["env_set"]["MOOD"] == "good"
        assert info["restart_policy"] == "always"
        assert info["stop_policy"] == "SIGINT, after 5 s SIGTERM, after 5 s SIGKILL"
        assert "env        MOOD=good" in run.ask_text("info", "it")


def test_resources_are_shown_once_they_are_known(control_bench: ControlBench):
    with control_bench.launch(SLEEPER) as run:
        wait_until(lambda: run.row("sleeper")["uss_bytes"], "its memory")
        row = run.row("sleeper")
        assert row["threads"] == 1
        assert row["uss_bytes"] <= row["rss_bytes"]
        with run.connect() as connection:
            looks = connection.follow("top", period_s=0.1)
            assert next(looks)["processes"][0]["name"] == "sleeper-1"
            assert next(looks)["processes"][0]["name"] == "sleeper-1"


def test_one_verb_is_explained(run: ControlledRun):
    assert run.ask_text("help", topic="kill").startswith("usage: kill NAME ... [-s SIGNAL]")
    assert run.ask_text("help", topic="exit").startswith("usage: quit")
    with pytest.raises(RefusedError, match="unknown verb 'kil'"):
        run.ask_text("help", topic="kil")


def test_level_alone_prints_the_current_filter(run: ControlledRun):
    assert run.ask_text("level") == "cat-1 shows all levels"
    run.ask_text("level", level="WARN")
    assert run.ask_text("level") == "cat-1 shows WARN and above"
    still = "; `level WARN` still hides lines"
    assert (
        run.ask_text("grep", pattern="task") == f"cat-1 shows only lines that match 'task'{still}"
    )


def test_one_word_shows_everything_again(control_bench: ControlBench):
    late = 'sh("exec cat", name="late")'
    other = f'sh("exec cat", name="other", on_exit=[{late}])'
    with control_bench.launch(f"{CAT}, {other}") as run:
        run.ask_text("solo", "cat")
        assert run.ask_text("level", level="ERROR").split("\n") == [
            "cat-1 shows ERROR and above",
            "1 process is hidden by `solo`: `show` shows everything",
        ]
        run.ask_text("grep", pattern="Fleet")
        for name in ("cat", "other"):
            run.ask_text("send", name, text="[INFO] not shown")
            run.wait_for_log(name, "not shown")
        assert [run.row(name)["hidden_by"] for name in ("cat", "other")] == [None, "solo"]
        for row in run.ask("ps")["processes"]:
            assert (row["level"], row["grep"], row["hidden_lines"]) == ("ERROR", "Fleet", 1)
        assert run.shell("show").stdout == "every process is shown again; 1 line was not shown\n"
        assert run.ask_text("show") == "nothing was hidden"
        run.ask_text("kill", "other", signal="KILL")
        wait_until(lambda: len(run.ask("ps")["processes"]) == 3, "a process that starts later")
        for name in ("cat", "late"):
            run.ask_text("send", name, text=f"{name} is shown")
            run.wait_for(f"{name} is shown\n")
        assert "not shown" not in run.screen


def test_a_mute_beside_a_solo_is_told_and_ends_with_a_solo_of_the_same(
    control_bench: ControlBench,
):
    with control_bench.launch(f"{CAT}, {SLEEPER}") as run:
        name = next(row["name"] for row in run.ask("ps")["processes"] if row["label"] != "cat")
        run.ask_text("solo", "cat")
        run.ask_text("mute", name)
        row = run.row(name)
        assert (row["hidden_by"], row["muted_by_name"]) == ("solo", True)
        assert "alone;" in run.ask_text("solo", "cat")
        assert run.row(name)["muted_by_name"]
        assert "is shown alone and no longer muted" in run.ask_text("solo", name)


def test_unmuting_without_a_muted_process_says_so(control_bench: ControlBench):
    with control_bench.launch(f"{CAT}, {SLEEPER}") as run:
        assert run.ask_text("unmute") == "no process was muted"


def test_the_plan_of_a_run_is_the_document_of_plan(control_bench: ControlBench):
    late = 'TimerAction(period=0.3, actions=[sh("exec cat", name="late")])'
    with control_bench.launch(
        f'DeclareLaunchArgument("speed", default_value="3"), {CAT}, {late}'
    ) as run:
        assert run.row("cat")["pid"]
        command = [*run.process.args[:-1], "plan", run.process.args[-1], "--json"]
        planned = subprocess.run(command, env=run.env, capture_output=True, check=True)
        wait_until(lambda: len(run.ask("plan")["processes"]) == 2, "both were asked for")
        asked = run.ask("plan")
        assert list(asked) == list(json.loads(planned.stdout))
        assert [one["cmd"] for one in asked["processes"]] == [["sh", "-c", "exec cat"]] * 2
        lines = run.ask_text("plan").splitlines()
        assert lines[1:4] == [
            "├── argument speed = '3'",
            "├── cat-1",
            "│       $ sh -c 'exec cat'",
        ]
        assert re.fullmatch(r"└── late-2  at [\d.]+ s", lines[4])


def test_the_format_of_lines_is_switched_while_it_runs(control_bench: ControlBench):
    with control_bench.launch(CAT) as run:
        assert run.ask_text("format") == "format: default"
        assert run.shell("format", "compact").stdout == "format: compact\n"
        run.ask_text("send", "cat", text="[ERROR] [1.0] [cat]: no port")
        run.wait_for(" E cat no port\n")
        run.ask_text("format", format="<{severity}> {message}")
        run.ask_text("send", "cat", text="[ERROR] [1.0] [cat]: no port")
        run.wait_for("\n<ERROR> no port\n")
        run.ask_text("format", format="default")
        run.ask_text("send", "cat", text="[ERROR] [1.0] [cat]: no port")
        run.wait_for("[cat-1] [ERROR] [1.0] [cat]: no port\n")
        assert run.log.count("[cat-1] [ERROR] [1.0] [cat]: no port\n") == 3
        with pytest.raises(RefusedError, match="unknown format 'bogus'"):
            run.ask_text("format", format="bogus")
