"""`engine: ssh` in the lab: what becomes of a run when something on the way breaks."""

from __future__ import annotations

import itertools
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.children import children_with, is_alive
from tests.support.hosts import Host, Lab
from tests.support.hosts.run import COUNT, Run, agents, is_clean, rest
from tests.support.waiting import wait_until

KEEP = {"on_link_loss": "keep"}
PLACE = {"count": "bot"}


@pytest.fixture(scope="module")
def bot(lab: Lab) -> Host:
    return lab.host("bot")


@pytest.fixture(autouse=True)
def nothing_is_left(bot: Host) -> Iterator[None]:
    yield
    if bot.pid:
        wait_until(lambda: is_clean(bot), f"nothing is left: {rest(bot)}")


def is_counting(run: Run, name: str = "count") -> None:
    """Wait for further lines."""
    number = len(run.counted(name)) + 20
    wait_until(lambda: len(run.counted(name)) > number, f"it counts: {run.text[-2000:]}")


def assert_complete(run: Run, name: str = "count") -> None:
    """All lines, once, in order, with growing times: one process that was never stopped."""
    numbers = [number for number, _ in run.counted(name)]
    times = [at_s for _, at_s in run.counted(name)]
    assert numbers == list(range(len(numbers)))
    assert times == sorted(times)


def counting(agent: int) -> int:
    """The pid of what the agent runs. By its whole program: its watchdog has a random word."""
    (process,) = children_with(agent, COUNT)
    return process.pid


def kill(*pids: int) -> None:
    for pid in pids:
        os.kill(pid, signal.SIGKILL)


def test_a_process_runs_there_and_ends_with_the_run(lab: Lab, bot: Host, tmp_path: Path):
    with Run(lab, tmp_path, {bot: {}}, PLACE) as run:
        run.wait_for(r"process started with pid \[\d+\] on bot")
        is_counting(run)
        refused = lab.operator.launcher("detach")
        assert "cannot detach from bot: processes of `engine: ssh` cannot" in refused.stderr
        assert run.stop() == 0
        assert_complete(run)
        assert not run.ssh_pids()


def test_ssh_is_killed(lab: Lab, bot: Host, tmp_path: Path):
    with Run(lab, tmp_path, {bot: KEEP}, PLACE) as run:
        is_counting(run)
        kill(*run.ssh_pids())
        run.wait_for("bot is unreachable")
        run.wait_for("bot is reachable again")
        is_counting(run)
        assert run.stop() == 0
        assert_complete(run)


def test_sshd_is_killed(lab: Lab, bot: Host, tmp_path: Path):
    with Run(lab, tmp_path, {bot: KEEP}, PLACE) as run:
        is_counting(run)
        bot.kill_sshd_sessions()
        number = run.wait_for("bot is reachable again")
        is_counting(run)
        bot.kill_sshd()
        number = run.wait_for("bot is unreachable", after=number)
        bot.start_sshd()
        run.wait_for("bot is reachable again", after=number)
        is_counting(run)
        assert run.stop() == 0
        assert_complete(run)


def test_the_agent_is_killed(lab: Lab, bot: Host, tmp_path: Path):
    with Run(lab, tmp_path, {bot: KEEP}, PLACE) as run:
        is_counting(run)
        kill(*agents(bot))
        run.wait_for("bot is lost: there is no agent")
        wait_until(lambda: not rest(bot), "its watchdog has killed the process")
        assert run.end() == 1


@pytest.mark.parametrize("policy", ["stop-after=3", "keep"])
def test_the_launcher_is_killed(lab: Lab, bot: Host, tmp_path: Path, policy: str):
    with Run(lab, tmp_path, {bot: {"on_link_loss": policy}}, PLACE) as run:
        is_counting(run)
        (agent,) = agents(bot)
        process = counting(agent)
        run.process.send_signal(signal.SIGKILL)
        run.process.wait()
        if policy == "keep":
            wait_until(lambda: len(rest(bot)) <= 3, "sshd lets go of the agent")
            assert is_alive(process)
            os.kill(agent, signal.SIGTERM)
        wait_until(lambda: not is_alive(process), "the process is stopped")


def test_the_host_is_switched_off(lab: Lab, tmp_path: Path):
    bot = lab.host("off")
    with Run(lab, tmp_path, {bot: {}}, {"count": "off"}) as run:
        is_counting(run)
        bot.power_off()
        run.wait_for("off is unreachable")
        assert run.stop() == 1
        assert "could not be reached: off (count-1)" in run.text


def test_the_host_is_switched_off_and_on(lab: Lab, tmp_path: Path):
    bot = lab.host("on")
    with Run(lab, tmp_path, {bot: KEEP}, {"count": "on"}) as run:
        is_counting(run)
        bot.power_off()
        bot.power_on()
        run.wait_for("on is lost: there is no agent")
        assert run.end() == 1


def test_the_link_is_down_for_8_seconds(lab: Lab, bot: Host, tmp_path: Path):
    with Run(lab, tmp_path, {bot: KEEP}, PLACE) as run:
        is_counting(run)
        (agent,) = agents(bot)
        bot.link_down()
        run.wait_for("bot is unreachable")
        before = run.counted("count")[-1][1]
        wait_until(lambda: proc_clock() > before + 8.0, "8 s pass")
        bot.link_up()
        run.wait_for("bot is reachable again.*caught up")
        is_counting(run)
        assert agents(bot) == [agent]
        assert run.stop() == 0
        assert_complete(run)
        times = [at_s for _, at_s in run.counted("count")]
        gaps = [after - before for before, after in itertools.pairwise(times)]
        assert max(gaps) < 3.0  # it was never made to wait for the link


def proc_clock() -> float:
    import time

    return time.monotonic()


def test_the_link_is_down_for_longer_than_the_policy(lab: Lab, bot: Host, tmp_path: Path):
    with Run(lab, tmp_path, {bot: {"on_link_loss": "stop-after=2"}}, PLACE) as run:
        is_counting(run)
        (agent,) = agents(bot)
        process = counting(agent)
        bot.link_down()
        wait_until(lambda: not is_alive(process), "it is stopped on the host itself")
        run.wait_for("bot is unreachable")
        bot.link_up()
        number = run.wait_for("process was stopped")
        run.wait_for("bot is reachable again", after=number)
        assert run.end() == 0


def test_a_full_disk_there_is_told(lab: Lab, bot: Host, tmp_path: Path):
    parameters = tmp_path / "big.yaml"
    parameters.write_bytes(b"# " + b"x" * 200_000)
    code = "import sys; print('started', sys.argv)"
    bot.full_disk("/tmp")
    try:
        with Run(lab, tmp_path, {bot: {}}, PLACE, code=code, pause=str(parameters)) as run:
            assert run.end() == 1
            assert "No space left on device" in run.text
    finally:
        bot.free_disk("/tmp")


# ---- who cannot be used: one error, and nothing is started


def refused(lab: Lab, bot: Host, folder: Path, **fields: object) -> str:
    with Run(lab, folder, {bot: fields}, PLACE) as run:
        assert run.end() == 1
    assert "process started" not in run.text
    return run.text


def with_ssh(lab: Lab, **options: object) -> dict[str, object]:
    return {**lab.ssh_options(), "IdentitiesOnly": "yes", **options}


def test_a_wrong_key_is_refused(lab: Lab, bot: Host, tmp_path: Path):
    key = bot.folder / "host_key"
    text = refused(lab, bot, tmp_path, ssh=with_ssh(lab, IdentityFile=str(key)))

    assert "login as root was refused" in text
    assert "ssh-copy-id" in text


def test_an_unknown_host_key_is_refused(lab: Lab, bot: Host, tmp_path: Path):
    text = refused(lab, bot, tmp_path, ssh=with_ssh(lab, UserKnownHostsFile="/dev/null"))

    assert "its host key is not known" in text


def test_a_changed_host_key_is_refused(lab: Lab, bot: Host, tmp_path: Path):
    bot.new_host_key()
    try:
        text = refused(lab, bot, tmp_path)
    finally:
        lab.trust(bot)

    assert "its host key has changed" in text
    assert "ssh-keygen" in text


def test_a_python_without_the_launcher_is_told(lab: Lab, bot: Host, tmp_path: Path):
    program = bot.home / "programs" / "bare"
    program.parent.mkdir(exist_ok=True)
    program.write_text('#!/bin/sh\nunset PYTHONPATH\nexec /usr/bin/python3 -I "$@"\n')
    program.chmod(0o755)

    text = refused(lab, bot, tmp_path, python="~/programs/bare")

    assert "does not have the launcher" in text
    assert "hosts sync" in text


def test_no_python_is_told(lab: Lab, bot: Host, tmp_path: Path):
    assert "there is no Python 'nopython'" in refused(lab, bot, tmp_path, python="nopython")


def test_a_launcher_without_agent_is_told(lab: Lab, bot: Host, tmp_path: Path):
    program = bot.home / "programs" / "old"
    program.parent.mkdir(exist_ok=True)
    old = "error: launch file 'agent' not found"
    program.write_text(f'#!/bin/sh\necho "{old}" >&2\nexit 2\n')
    program.chmod(0o755)

    text = refused(lab, bot, tmp_path, python="~/programs/old")

    assert "too old" in text
    assert "hosts sync" in text


# ---- many, and slow


def test_twelve_processes_share_one_session(lab: Lab, bot: Host, tmp_path: Path):
    before = bot.sshd_log.count("Starting session")
    place = {f"count_{number}": "bot" for number in range(12)}
    with Run(lab, tmp_path, {bot: {}}, place, pause="0.2") as run:
        for name in place:
            wait_until(lambda name=name: run.counted(name), f"{name} counts")
        assert run.stop() == 0
    assert bot.sshd_log.count("Starting session") - before == 1


def test_a_slow_link_loses_nothing(lab: Lab, bot: Host, tmp_path: Path):
    bot.slow_link(delay_s=0.1, loss=0.02, bytes_per_s=200_000)
    try:
        with Run(lab, tmp_path, {bot: KEEP}, PLACE, pause="0.001") as run:
            wait_until(lambda: len(run.counted("count")) > 1500, "it counts")
            assert run.stop() == 0
            assert_complete(run)
    finally:
        bot.normal_link()
