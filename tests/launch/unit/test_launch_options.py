"""Parsing of restart policies, limits, stop signals and budgets of `launch`."""

import os
import signal

import pytest

from launcher.base.command_line import Command
from launcher.base.errors import LaunchFileError, UsageError
from launcher.base.model.record import replace
from launcher.base.model.run_options import RunOptions, matches
from launcher.base.model.spec import (
    Limits,
    ProcessSpec,
    RestartMode,
    RestartPolicy,
    RosIdentity,
    StopPolicy,
)
from launcher.base.option import option
from launcher.launch.launch_options import RUN_OPTIONS, run_options
from launcher.launch.process_options import parse_cpus, parse_limit, parse_restart, parse_stop
from launcher.run.monitor.enforcement import judge_for


def read(words: list[str]) -> RunOptions:
    """The options about the run that a command line names."""
    return run_options(Command("", "", (option("[WORD ...]"),), RUN_OPTIONS).parse(words))


def spec(name: str, node_name: str | None = None) -> ProcessSpec:
    label = name.rpartition("-")[0]
    return ProcessSpec(
        name=name, label=label, argv=(label,), env={}, ros=RosIdentity(node_name=node_name)
    )


def test_a_whole_restart_policy_is_read():
    pattern, policy = parse_restart("robot_2=on-failure,max=5,window=60,backoff=0.5..30")
    assert pattern == "robot_2"
    assert policy == RestartPolicy(
        mode=RestartMode.ON_FAILURE,
        max_restarts=5,
        window_s=60.0,
        delay_s=0.5,
        backoff_max_s=30.0,
        jitter=0.1,
    )


@pytest.mark.parametrize(
    ("word", "says"),
    [
        ("robot_2", "expected NAME=..."),
        ("robot_2=sometimes", "never, on-failure, always"),
        ("=always", "expected NAME=..."),
        ("a=always,maximum=3", "unknown setting 'maximum'"),
        ("a=always,max=three", "'max=three' is not a whole number"),
        ("a=always,max=1e9", "'max=1e9' is not a whole number"),
        ("a=always,max=-1", "'max=-1' is not a whole number"),
        ("a=always,max=1,window=3,max=2", "'max' is given twice"),
        ("a=always,backoff=5..1", "'backoff=5..1' is not two .* the second not below the first"),
        ("a=always,delay=1,backoff=1..5", "'delay' and 'backoff' exclude"),
        ("a=always,delay=inf", "'delay=inf' is not a number"),
        ("a=always,backoff=1", "'backoff=1' is not two numbers"),
    ],
)
def test_a_wrong_policy_is_refused_with_an_example(word, says):
    with pytest.raises(UsageError, match=says) as caught:
        parse_restart(word)
    assert caught.value.hint.startswith("for example: --restart")


@pytest.mark.parametrize("pattern", ["robot_2-4", "robot_2", "robot_*", "porter", "/fleet/porter"])
def test_a_process_is_selected_by_name_label_node_name_or_pattern(pattern):
    assert matches(pattern, spec("robot_2-4", "/fleet/porter"))


def test_a_process_is_not_selected_by_a_part_of_its_name():
    assert not matches("robot", spec("robot_2-4"))


def test_the_last_policy_that_matches_counts():
    options = RunOptions(
        restart=(parse_restart("*=always"), parse_restart("robot_2=never")),
    )
    assert options.adapt(spec("robot_1-1")).restart.mode is RestartMode.ALWAYS
    assert options.adapt(spec("robot_2-2")).restart.mode is RestartMode.NEVER
    assert options.adapt(spec("robot_1-1")).argv == ("robot_1",)


def test_options_are_taken_wherever_they_stand():
    words = ["--timeout", "2.5", "system", "--required=robot_*", "a:=1", "--no-log-files"]
    options = read([*words, "--restart", "x=always"])
    assert (options.timeout_s, options.required, options.log_files) == (2.5, ("robot_*",), False)
    assert options.restart[0][1].mode is RestartMode.ALWAYS
    assert not options.exit_when_any_dies


@pytest.mark.parametrize(
    "words", [["--timeout"], ["--timeout", "soon"], ["--timeout=0"], ["--restart"]]
)
def test_an_option_without_a_good_value_is_refused(words):
    with pytest.raises(UsageError):
        read(words)


# ---- options about single processes

INT, TERM, QUIT = signal.SIGINT, signal.SIGTERM, signal.SIGQUIT


@pytest.mark.parametrize(
    ("word", "polite"),
    [
        ("robot_*=int:2,term:1", ((INT, 2.0), (TERM, 1.0))),
        ("robot_*=SIGTERM:0.5,kill", ((TERM, 0.5),)),
        ("robot_*=quit", ((QUIT, 5.0),)),
        ("robot_*=kill", ()),
    ],
)
def test_a_way_to_stop_is_read(word, polite):
    assert parse_stop(word) == ("robot_*", StopPolicy(polite=polite))


@pytest.mark.parametrize(
    ("text", "soft_and_hard"),
    [
        ("nofile=256", ("nofile", 256, 256)),
        ("as=1.5G", None),
        ("as=1g", ("as", 1 << 30, 1 << 30)),
        ("core=0/unlimited", ("core", 0, -1)),
        ("nofile=2/1", None),
        ("nofile=unlimited/1", None),
        ("nofile=", None),
        ("nofiles=1", None),
        ("nofile=99999999999G", None),
    ],
)
def test_a_limit_is_read_or_refused(text, soft_and_hard):
    if soft_and_hard is not None:
        limits = Limits(rlimits=(soft_and_hard,))
        assert parse_limit(f"x:{text}", most_granted=lambda name: -1) == ("x", limits)
        return
    with pytest.raises(UsageError, match="in 'x:") as caught:
        parse_limit(f"x:{text}")
    assert caught.value.hint.startswith("for example: --limit")


@pytest.mark.parametrize("text", ["nproc=unlimited", "nproc=0/unlimited", "nproc=4001"])
def test_a_limit_above_what_is_granted_is_refused_with_that(text):
    with pytest.raises(UsageError, match="more than is allowed here: the hard limit is 4000"):
        parse_limit(f"x:{text}", most_granted=lambda name: 4000)
    assert parse_limit("x:nproc=4000", most_granted=lambda name: 4000)[0] == "x"


def test_a_limit_beyond_the_kernels_maximum_is_refused_on_the_command_line():
    with pytest.raises(UsageError, match="'nofile=unlimited' is more than is allowed here"):
        read(["--limit", "x:nofile=unlimited"])


def test_other_hosts_may_grant_more_than_this_machine():
    words = ["--cpus", "x=4000", "--limit=x:nofile=unlimited"]
    (_, cpus), (_, rlimits) = read([*words, "--hosts", "hosts.yaml"]).limits
    assert cpus == Limits(cpus=(4000,))
    assert rlimits == Limits(rlimits=(("nofile", -1, -1),))
    for word in (words[:2], words[2:]):
        with pytest.raises(UsageError, match=r"this machine has|more than is allowed here"):
            read(word)


def test_processors_are_read_as_a_list_with_ranges():
    last = (os.cpu_count() or 1) - 1
    assert parse_cpus(f"x=0-{last},0") == ("x", Limits(cpus=tuple(range(last + 1))))


@pytest.mark.parametrize(
    "words",
    [
        ["--stop", "x=int:soon"],
        ["--stop", "x=interrupt"],
        ["--stop", "x=kill,int"],
        ["--stop", "x=kill:3"],
        ["--stop", "x"],
        ["--nice", "x=20"],
        ["--nice", "x=high"],
        ["--cpus", "x=3-1"],
        ["--cpus", "x=99999"],
        ["--cpus", "x=-1"],
        ["--limit", "x=nofile=3"],
        ["--stagger", "-1"],
        ["--max-starting", "0"],
        ["--max-starting", "two"],
    ],
)
def test_a_wrong_word_about_a_process_is_refused(words):
    with pytest.raises(UsageError):
        read(words)


def test_a_later_limit_overrides_only_the_values_it_names():
    words = ["--limit", "*:nofile=9,core=0", "--nice", "robot_*=5", "--limit", "robot_1:nofile=7"]
    options = read([*words, "--stop", "robot_1=term:3"])
    adapted = options.adapt(spec("robot_1-1"))
    assert adapted.limits == Limits(nice=5, rlimits=(("nofile", 7, 7), ("core", 0, 0)))
    assert adapted.stop.steps[0] == (TERM, 3.0)
    assert options.adapt(spec("other-2")).limits == Limits(
        rlimits=(("nofile", 9, 9), ("core", 0, 0))
    )


def test_a_policy_file_equals_the_options(tmp_path):
    file = tmp_path / "budgets.yaml"
    file.write_text(
        "robot_*: {memory: 200M, restart: 'on-failure,max=5', stop: 'int:2', nice: 5}\n"
        "robot_1:\n  cpus: 0\n  limit: nofile=256,core=0\n"
    )
    from_file = read(["--budgets", str(file)])
    words = ["--restart", "robot_*=on-failure,max=5", "--stop", "robot_*=int:2"]
    limits = ["--nice", "robot_*=5", "--cpus", "robot_1=0", "--limit", "robot_1:nofile=256,core=0"]
    from_words = read([*words, *limits])
    names = (("robot_*", f"{file}:1"), ("robot_1", f"{file}:2"))
    budgets = tuple(judge_for(read(["--budget", "robot_*:memory=200M"])).budgets)
    assert from_file == replace(from_words, file_budgets=budgets, file_names=names)
    assert [budget.pattern for budget in judge_for(from_file).budgets] == ["robot_*"]


def test_a_file_that_is_a_pipe_is_read_once_and_of_several_each_counts(tmp_path):
    read_end, write_end = os.pipe()
    os.write(write_end, b"a: {memory: 1M}")
    os.close(write_end)
    (tmp_path / "other.yaml").write_text("b: {fds: 9}")
    words = ["--budgets", f"/dev/fd/{read_end}", "--budgets", str(tmp_path / "other.yaml")]
    options = read(words)
    os.close(read_end)
    assert [budget.pattern for budget in judge_for(options).budgets] == ["a", "b"]


@pytest.mark.parametrize(
    ("line", "says"), [("stop: int:soon", "number of seconds"), ("nicee: 3", "unknown key 'nicee'")]
)
def test_a_mistake_in_the_policy_file_is_reported_with_its_line(tmp_path, line, says):
    file = tmp_path / "budgets.yaml"
    file.write_text(f"robot_*:\n  memory: 1G\n  {line}\n")
    with pytest.raises(LaunchFileError, match=says) as caught:
        read(["--budgets", str(file)])
    assert caught.value.where == f"{file}:3"
