"""Hosts that cannot be synchronized, and an interrupted `hosts sync`; a shell instead of ssh."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import io
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from io import BufferedReader
from pathlib import Path

import psutil
import pytest

from launcher.base.errors import LauncherError
from launcher.base.model.record import replace
from launcher.hosts.failures import HostError, Problem
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.ssh import host_python
from launcher.hosts.sync.fleet_sync import FleetSync
from launcher.hosts.sync.host_sync import SyncOptions, SyncOutcome
from launcher.hosts.sync.on_host import wire
from launcher.hosts.sync.on_host.main import Requests, SyncService
from launcher.hosts.sync.on_host.store import HostStore, Refusal, disk_errors
from launcher.hosts.sync.release_tree import TreeEntry
from launcher.hosts.verbs.sync_report import SyncReport, joined
from tests.support.sync_hosts import Site, brought, fails
from tests.support.waiting import wait_until


@pytest.fixture
def site(tmp_path: Path) -> Site:
    return Site(tmp_path / "bot one")


def test_hosts_fail_apart(tmp_path: Path):
    good, bad = Site(tmp_path / "good"), Site(tmp_path / "bad", setup=("no $(touch injected).sh",))
    sites = {site.host.name: site for site in (good, bad)}

    def words(host: Host, script: str) -> list[str]:
        return list(sites[host.name].words(host, script))

    fleet = FleetSync(SyncOptions(), lambda *_: None, words)
    results = fleet.sync([bad.host, good.host], brought(a="1"))

    assert isinstance(results[0], LauncherError) and isinstance(results[1], SyncOutcome)
    assert "host 'bad': there is no setup file 'no $(touch injected).sh'" in results[0].message
    assert not (bad.home / "injected").exists()


@pytest.mark.parametrize("python", [".venv/bin/python", "python9"])
def test_a_host_without_the_python_of_the_hosts_file_is_synchronized(tmp_path: Path, python: str):
    """What is to be made there cannot be what it is made with."""
    site = Site(tmp_path / "bot", python=python)

    site.sync(brought(a="1"))
    again = site.sync(brought(a="1"))

    assert site.run("-c", "print(1)") == "1\n"
    assert site.messages[0] == f"there is no Python '{python}', so python3 is used"
    assert (site.current / "bin/.python").read_text() == f"python3\n{host_python(site.host)}\n"
    assert not again.is_changed


def test_a_host_without_any_python_is_told(site: Site):
    def words(host: Host, script: str) -> list[str]:
        return ["env", "-i", f"HOME={site.home}", "PATH=/nothing", "/bin/sh", "-c", script]

    host = replace(site.host, python="python9")
    (error,) = FleetSync(SyncOptions(), lambda *_: None, words).sync([host], brought(a="1"))

    assert isinstance(error, LauncherError)
    assert "there is no Python 'python3', nor one that the hosts file names" in error.message
    assert "install Python 3.10" in (error.hint or "")


def test_what_a_login_shell_prints_does_no_harm(site: Site):
    def words(host: Host, script: str) -> Sequence[str]:
        return site.words(host, f"echo welcome; printf '\\0\\1'; echo; {script}")

    (done,) = FleetSync(SyncOptions(), lambda *_: None, words).sync([site.host], brought(a="1"))

    assert isinstance(done, SyncOutcome) and done.is_changed


def test_a_workspace_that_is_a_file_is_told(site: Site):
    (site.home / ".local").write_text("")

    assert "Not a directory" in fails(site, brought(a="1")).message


def test_a_full_disk_is_told_before_anything_is_sent(site: Site):
    huge = TreeEntry(path="huge", content=b"")
    files = brought()
    files.tree.add(huge)
    fleet = site.fleet()
    from launcher.hosts.sync.release_tree import Release

    release = Release(list(files.tree.entries.values()))
    release.sizes = dict.fromkeys(release.sizes, 10**18)
    results = fleet._for_all([site.host], lambda sync: sync.run(release, []))

    assert isinstance(results[0], LauncherError)
    assert "MB are needed there" in results[0].message
    assert not site.current.exists()


def test_the_same_error_of_several_hosts_is_told_once():
    hosts = [Host(name=name, address="10.0.0.2") for name in ("a", "b", "c")]
    errors = [HostError(host, Problem.OTHER, "no network", hint="do it") for host in hosts[:2]]
    other = HostError(hosts[2], Problem.OTHER, "its disk is full")

    found = [*joined([*errors, other])]

    assert [(one.message, one.hint) for one in found] == [
        ("hosts a, b: no network", "do it"),
        ("host 'c': its disk is full", None),
    ]


def test_a_host_is_told_when_it_is_done_and_those_that_are_not_at_ctrl_c(tmp_path: Path, capsys):
    good, slow, bad = (Site(tmp_path / name) for name in ("good", "slow", "bad"))
    (bad.home / ".local").write_text("")
    slow.workspace.mkdir(parents=True)
    sites = {site.host.name: site for site in (slow, good, bad)}
    hosts = [site.host for site in sites.values()]
    report = SyncReport(hosts, dry_run=False)
    told: list[str] = []

    def add(host: Host, result: SyncOutcome | LauncherError) -> None:
        report.add(host, result)
        told.append(host.name)
        if len(told) == 2:
            raise KeyboardInterrupt

    fleet = FleetSync(SyncOptions(), lambda *_: None, lambda h, t: sites[h.name].words(h, t), add)
    with open(slow.workspace / ".lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(KeyboardInterrupt):
            fleet.sync(hosts, brought(a="1"))
    report.interrupt()

    assert {*told} == {"good", "bad"}
    shown = capsys.readouterr()
    assert shown.out.startswith("good: 000001-") and shown.out.count("\n") == 1
    assert shown.err.startswith("bad: failed, see below\nerror: host 'bad': ")
    hint = "a release is used only when it is complete: repeat the command"
    last = f"interrupted; not done: slow ({hint})\n"
    assert shown.err.endswith(last)
    assert (good.current / "a").exists() and not slow.current.exists()


class TwoSites:
    """The host `slow` is held until `done` was called for the other, and has then raised."""

    def __init__(self, folder: Path, exception: BaseException) -> None:
        self._exception = exception
        self.good, self.slow = Site(folder / "good"), Site(folder / "slow")
        self.slow.workspace.mkdir(parents=True)
        self.lock = os.open(self.slow.workspace / ".lock", os.O_CREAT | os.O_RDWR)
        fcntl.flock(self.lock, fcntl.LOCK_EX)
        self.hosts = [self.slow.host, self.good.host]
        self.report = SyncReport(self.hosts, dry_run=False)
        self.fleet = FleetSync(SyncOptions(), self._say, self._words, self._done)
        self.said: list[str] = []
        self.waits_for_slow = False

    def _words(self, host: Host, script: str) -> Sequence[str]:
        return (self.good if host.name == "good" else self.slow).words(host, script)

    def _say(self, name: str, text: str) -> None:
        self.said.append(name)
        raise BrokenPipeError

    def _done(self, host: Host, result: SyncOutcome | LauncherError) -> None:
        if host.name == "good":
            wait_until(lambda: self.said == ["slow"], "the other says that it waits")
        self.report.add(host, result)
        if host.name == "good":
            os.close(self.lock)
            if self.waits_for_slow:
                wait_until(lambda: not self.fleet._sessions, "the other is done")
            raise self._exception


def test_output_that_nobody_reads_leaves_no_host_half_done(tmp_path: Path, capsys):
    sites = TwoSites(tmp_path, BrokenPipeError())

    with pytest.raises(BrokenPipeError):
        sites.fleet.sync(sites.hosts, brought(a="1"))

    assert sites.report.end() == 0
    assert (sites.good.current / "a").exists() and (sites.slow.current / "a").exists()
    assert [line.split(":")[0] for line in capsys.readouterr().out.splitlines()] == ["good", "slow"]


def test_ctrl_c_names_no_host_that_is_done(tmp_path: Path, capsys):
    sites = TwoSites(tmp_path, KeyboardInterrupt())
    sites.waits_for_slow = True

    with pytest.raises(KeyboardInterrupt):
        sites.fleet.sync(sites.hosts, brought(a="1"))
    sites.report.interrupt()

    shown = capsys.readouterr()
    assert [line.split(":")[0] for line in shown.out.splitlines()] == ["good", "slow"]
    assert shown.err == ""


def test_ctrl_c_does_not_advise_to_repeat_what_goes_back_once_more(capsys):
    report = SyncReport([Host(name="a", address="10.0.0.2")], dry_run=False, rollback=True)
    report.interrupt()
    assert capsys.readouterr().err == "interrupted; not done: a\n"


def test_a_disk_that_is_full_before_anything_is_sent_is_named(tmp_path: Path):
    workspace = HostStore(str(tmp_path))
    with pytest.raises(Refusal, match=re.escape(str(tmp_path))) as caught, disk_errors(workspace):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert "make space" in caught.value.hint
    requests, answers = io.BytesIO(), io.BytesIO()
    wire.send(requests, {"do": "full"})
    requests.seek(0)

    _FullDisk(requests, answers, workspace).run()

    answers.seek(0)
    assert str(tmp_path) in wire.receive(answers)["error"]


class _FullDisk(SyncService):
    """Has one request, which fails."""

    def __init__(self, requests: io.BytesIO, answers: io.BytesIO, workspace: HostStore) -> None:
        super().__init__(Requests(BufferedReader(requests)), answers)
        self._workspace = workspace

    def _do_full(self, request: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")


def test_pip_ends_with_the_operator(tmp_path: Path):
    """Ctrl-C closes the session; what pip has started ends, too."""
    code = """
from launcher.hosts.sync.on_host import environment
environment._run(["sh", "-c", f"echo $$ > {PATH!r}; sleep 600 | sleep 600"], "pip failed")
""".replace("{PATH!r}", str(tmp_path / "pid"))
    receiver = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE)
    assert receiver.stdin is not None
    wait_until(lambda: (tmp_path / "pid").exists() and (tmp_path / "pid").read_text(), "it runs")
    group = int((tmp_path / "pid").read_text())

    receiver.stdin.close()

    assert receiver.wait(60) != 0
    wait_until(lambda: not _members(group), "what pip has started ends")


def _members(group: int) -> list[int]:
    found = []
    for pid in psutil.pids():
        with contextlib.suppress(OSError):
            if os.getpgid(pid) == group:
                found.append(pid)
    return found
