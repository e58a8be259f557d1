"""Units of systemd: names, settings, quoting."""

from __future__ import annotations

import signal
import subprocess

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.base.model.spec import Limits, RestartMode, RestartPolicy, StopPolicy
from launcher.hosts import unit
from launcher.hosts.unit import UnitSetting

ALWAYS, ON_FAILURE = RestartMode.ALWAYS, RestartMode.ON_FAILURE


def lines(settings) -> list[str]:
    return [str(one) for one in settings]


@pytest.mark.parametrize(
    ("parts", "name"),
    [
        (("k3f9", "robot_1-2"), "launcher-k3f9-robot_1-2.service"),
        (("k3f9", "a b@c/d"), r"launcher-k3f9-a\x20b\x40c\x2fd.service"),
        (("k3f9", "é"), r"launcher-k3f9-\xc3\xa9.service"),
    ],
)
def test_names(parts: tuple[str, ...], name: str):
    assert unit.unit_name(*parts) == name


def test_a_dash_in_the_name_of_a_slice_would_make_a_slice_within_another():
    assert unit.slice_name("a-b") == r"launcher_a\x2db.slice"


@given(st.text(min_size=1), st.text(min_size=1))
def test_names_are_valid_and_short(first: str, second: str):
    name = unit.unit_name(first, second * 40)

    assert len(name) <= unit.MAX_NAME
    assert set(name) <= set("-:_.\\") | {c for c in map(chr, range(128)) if c.isalnum()}


def test_long_names_stay_different():
    one, other = unit.unit_name("x" * 300 + "1"), unit.unit_name("x" * 300 + "2")

    assert one != other
    assert len(one) == unit.MAX_NAME


def test_no_restart():
    assert lines(unit.restart_settings(RestartPolicy())) == ["Restart=no"]
    assert lines(unit.restart_settings(RestartPolicy(ALWAYS, max_restarts=0))) == ["Restart=no"]


def test_restart_without_limit():
    assert lines(unit.restart_settings(RestartPolicy(ALWAYS, delay_s=1.5))) == [
        "Restart=always",
        "RestartSec=1500ms",
        "StartLimitIntervalSec=0",
    ]


def test_an_exit_by_a_signal_that_systemd_takes_for_clean_is_a_failure():
    settings = lines(unit.restart_settings(RestartPolicy(ON_FAILURE)))

    assert "RestartForceExitStatus=SIGHUP SIGINT SIGTERM SIGPIPE" in settings


@pytest.mark.parametrize(("window_s", "interval"), [(None, "infinity"), (60.0, "60s")])
def test_the_first_start_counts_for_the_limit(window_s: float | None, interval: str):
    policy = RestartPolicy(ALWAYS, max_restarts=3, window_s=window_s)

    settings = list(unit.restart_settings(policy))

    assert UnitSetting("StartLimitIntervalSec", interval, "Unit") in settings
    assert UnitSetting("StartLimitBurst", "4", "Unit") in settings


def test_a_delay_that_doubles():
    policy = RestartPolicy(ALWAYS, delay_s=1.0, backoff_max_s=8.0)

    known, unknown = unit.supported(unit.restart_settings(policy), 252)
    assert lines(unknown) == ["RestartSteps=3", "RestartMaxDelaySec=8s"]
    assert "RestartSec=1s" in lines(known)
    assert unit.supported(unit.restart_settings(policy), 254)[1] == ()


def test_stop():
    assert lines(unit.stop_settings(StopPolicy())) == [
        "KillMode=control-group",
        "KillSignal=SIGINT",
        "TimeoutStopSec=10s",
        "SendSIGKILL=yes",
    ]


def test_a_closed_pipe_ends_a_process_as_without_systemd():
    settings = lines(unit.process_settings(RestartPolicy(), StopPolicy(), None))

    assert "IgnoreSIGPIPE=no" in settings


def test_a_stop_without_patience_is_not_one_without_end():
    settings = lines(unit.stop_settings(StopPolicy(polite=())))

    assert "KillSignal=SIGKILL" in settings
    assert "TimeoutStopSec=1ms" in settings


def test_limits():
    limits = Limits(nice=5, cpus=(0, 2), rlimits=(("nofile", 256, 1024), ("core", -1, -1)))

    assert lines(unit.limit_settings(limits)) == [
        "Nice=5",
        "CPUAffinity=0 2",
        "LimitNOFILE=256:1024",
        "LimitCORE=infinity:infinity",
    ]


def test_what_systemd_does_otherwise_is_named():
    policy = RestartPolicy(ALWAYS, delay_s=1.0, backoff_max_s=8.0, jitter=0.5)

    assert list(unit.unmet(policy, StopPolicy(), 252)) == [
        "its restart delay does not grow (needs systemd 254, has 252)",
        "its restart delay has no random part",
        "SIGTERM is left out when systemd stops it by itself",
    ]
    once = StopPolicy(polite=((signal.SIGTERM, 1.0),))
    assert list(unit.unmet(RestartPolicy(), once, 252)) == []


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (("/bin/echo", "a b"), '/bin/echo "a b"'),
        (("/bin/echo", "$HOME", "50%"), '/bin/echo "$$HOME" "50%%"'),
        (("/opt/a b/$x", "", ";"), '"/opt/a b/$x" "" ";"'),
        (("-x", "a\n\tb\x01"), '"-x" "a\\n\\tb\\x01"'),
    ],
)
def test_command_lines(words: tuple[str, ...], line: str):
    assert unit.exec_line(words) == line


def test_a_description_is_one_line_without_specifiers():
    assert unit.literal("50%\nof it") == "50%% of it"


VALUES = st.text(st.characters(exclude_categories=["Cs", "Cc"]) | st.sampled_from("\n\t\"'\\$`"))


@given(st.lists(VALUES, min_size=1, max_size=20))
def test_a_shell_reads_environment_files_as_well(values: list[str]):
    variables = {f"V{index}": value for index, value in enumerate(values)}
    script = f"set -a\n{unit.environment_file(variables)}\nset +a\nexec env -0"

    result = subprocess.run(
        ["/bin/sh"], input=script.encode(), env={}, capture_output=True, check=True
    )

    pairs = [entry.split("=", 1) for entry in result.stdout.decode().split("\0") if entry]
    assert {name: value for name, value in pairs if name in variables} == variables


@pytest.mark.parametrize(
    ("name", "value"), [("A-B", "x"), ("A", "\x1b"), ("A", "\udc80"), ("A\n", "x"), ("", "")]
)
def test_what_does_not_fit_is_refused_without_its_value(name: str, value: str):
    with pytest.raises(ValueError, match="does not fit") as error:
        unit.environment_file({name: value})

    assert not value.strip() or value not in str(error.value)
