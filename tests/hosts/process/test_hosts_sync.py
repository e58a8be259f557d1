"""`hosts sync` on hosts that are a shell and a home of this machine: the same program, no ssh."""

from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import psutil
import pytest

from launcher.base.errors import LauncherError
from launcher.hosts.sync.host_sync import SyncOutcome
from launcher.hosts.sync.release_tree import TreeEntry
from tests.support import ended_main_thread
from tests.support.sync_hosts import Site, brought, fails
from tests.support.waiting import wait_until

ODD = "a b\n'\"$(touch injected);ü\udcff*"


@pytest.fixture
def site(tmp_path: Path) -> Site:
    return Site(tmp_path / "bot one")


# ---- what is sent


def test_a_second_sync_sends_nothing(site: Site):
    files = brought(lib__a="1", lib__b="2")

    first, second = site.sync(files), site.sync(files)

    assert (first.sent_files, first.is_changed) == (4, True)  # with bin/python and bin/.python
    assert (second.sent_files, second.sent_bytes, second.is_changed) == (0, 0, False)
    assert second.release == first.release == site.release


def test_only_what_has_changed_is_sent_and_the_rest_is_shared(site: Site):
    site.sync(brought(a="same", b="1", c="moved"))
    before = site.current.resolve()

    done = site.sync(brought(a="same", b="2", new__c="moved"))

    after = site.current.resolve()
    assert done.sent_files == 1
    assert (after / "b").read_text() == "2"
    assert (after / "a").stat().st_ino == (before / "a").stat().st_ino
    assert (after / "new/c").stat().st_ino == (before / "c").stat().st_ino
    assert (before / "b").read_text() == "1"


def test_names_of_any_kind_arrive_and_nothing_is_executed(site: Site):
    site.sync(brought(**{ODD: "odd", f"d{ODD}__{ODD}": "below"}))

    assert (site.current / ODD).read_text() == "odd"
    assert (site.current / f"d{ODD}" / ODD).read_text() == "below"
    assert not list(site.home.rglob("injected"))


def test_modes_and_links_arrive(site: Site):
    files = brought(plain="x")
    files.tree.add(TreeEntry(path="program", content=b"x", is_executable=True))
    files.tree.add(TreeEntry(path="lib/libx.so", target="libx.so.1"))
    files.tree.add(TreeEntry(path="lib/libx.so.1", content=b"library"))

    site.sync(files)

    assert os.access(site.current / "program", os.X_OK)
    assert (site.current / "plain").stat().st_mode & 0o777 == 0o444
    assert os.readlink(site.current / "lib/libx.so") == "libx.so.1"
    assert (site.current / "lib/libx.so").read_bytes() == b"library"


def test_a_large_file_is_sent_in_blocks(site: Site, tmp_path: Path):
    content = os.urandom(3_000_000) + bytes(30_000_000)
    (tmp_path / "map.bin").write_bytes(content)
    files = brought()
    files.tree.add(TreeEntry(path="share/map.bin", source=str(tmp_path / "map.bin")))

    done = site.sync(files)

    assert (site.current / "share/map.bin").read_bytes() == content
    assert done.sent_bytes < 4_000_000  # compressed


def test_a_file_that_was_changed_there_is_brought_again(site: Site):
    files = brought(a="right", b="b")
    site.sync(files)
    damaged = site.current / "a"
    damaged.chmod(0o644)
    damaged.write_text("wrong")

    done = site.sync(files)

    assert (site.current / "a").read_text() == "right"
    assert done.sent_files == 1


def test_force_sends_everything(site: Site):
    files = brought(a="1", b="2")
    site.sync(files)

    assert site.sync(files, force=True).sent_files == 4


def test_a_dry_run_tells_the_changes_and_makes_none(site: Site):
    site.sync(brought(a="1", b="1"))
    names = sorted(site.home.rglob("*"))

    done = site.sync(brought(b="2", c="1"), dry_run=True)

    assert done.changes == ("+ c", "~ b", "- a")
    assert done.sent_files == 1  # the content of c is there
    assert sorted(site.home.rglob("*")) == names


def test_a_dry_run_on_a_new_host_writes_nothing(site: Site):
    site.sync(brought(a="1"), dry_run=True)

    assert list(site.home.iterdir()) == []


def test_a_file_that_changes_while_it_is_sent_is_named(site: Site, tmp_path: Path):
    class Changing(TreeEntry):
        def blocks(self):
            yield os.urandom(8)

    files = brought(a="1")
    log = tmp_path / "growing.log"
    log.write_text("")
    files.tree.add(Changing(path="share/growing.log", source=str(log)))

    error = fails(site, files)

    assert f"{log} was changed while it was sent" in error.message
    assert not site.current.exists()


# ---- releases


def test_rollback_goes_back_step_by_step_and_sync_forward_again(site: Site):
    names = [site.sync(brought(a=text)).release for text in "123"]

    back = [site.roll_back().release, site.roll_back().release]
    again = site.sync(brought(a="3"))

    assert back == [names[1], names[0]]
    assert again.sent_files == 0
    assert (site.current / "a").read_text() == "3"
    assert site.roll_back().release == names[0]  # what was used before


def test_rollback_without_an_older_release_is_an_error(site: Site):
    with pytest.raises(LauncherError, match="nothing was brought there yet"):
        site.roll_back()
    site.sync(brought(a="1"))
    with pytest.raises(LauncherError, match="there is no release before 000001"):
        site.roll_back()


def test_a_dry_rollback_changes_nothing(site: Site):
    first, second = (site.sync(brought(a=text)).release for text in "12")

    done = site.roll_back(dry_run=True)

    assert (done.before, done.release) == (second, first)
    assert site.release == second


def test_three_releases_are_kept(site: Site):
    names = [site.sync(brought(a=text)).release for text in "12345"]

    assert site.releases == names[2:]


WAITS = "import time; print('ready', flush=True); time.sleep(600)"


@pytest.mark.parametrize(
    "words",
    [("-c", WAITS), pytest.param((ended_main_thread.PROGRAM,), marks=pytest.mark.thorough)],
    ids=["", "ended main thread"],
)
def test_a_release_that_a_process_uses_is_kept(site: Site, words: tuple[str, ...]):
    site.sync(brought(a="1"))
    first = site.release
    command = [str(site.current / "bin/python"), *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stdout.readline() == b"ready\n"
        for text in "2345":
            site.sync(brought(a=text))
        assert first in site.releases
        process.kill()
    site.sync(brought(a="6"))
    assert first not in site.releases


# ---- interruptions


def test_a_killed_receiver_leaves_the_old_release_and_what_was_received(site: Site, tmp_path: Path):
    site.sync(brought(a="old"))
    old = site.release
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    files = brought(a="new", b="b" * 5000)
    entries = list(files.tree.entries.values())
    reader = threading.Thread(target=lambda: fails(site, files))
    files.tree.entries["z"] = _Slow(path="z", content=b"z", is_executable=False)

    reader.start()
    wait_until(lambda: len(_incoming(site)) == len(entries), "two files are there")
    os.kill(_receiver(site), signal.SIGKILL)
    _Slow.go.set()
    reader.join(60)

    assert site.release == old and site.releases == [old]
    done = site.sync(files)
    assert done.sent_files == 1
    assert (site.current / "z").read_text() == "z"
    assert _incoming(site) == []


class _Slow(TreeEntry):
    """Is read at once when it is measured; when it is sent, only after `go`."""

    go = threading.Event()

    def blocks(self):
        caller = sys._getframe(1).f_code.co_name
        if caller != "_measured" and not self.go.is_set():
            yield b""
            self.go.wait(60)
        yield b"z"


def _incoming(site: Site) -> list[str]:
    folder = site.workspace / "incoming"
    return sorted(n for n in os.listdir(folder) if n[0] != ".") if folder.exists() else []


def _receiver(site: Site) -> int:
    processes = [one.info for one in psutil.process_iter(["cmdline", "environ", "pid"])]
    receivers = [one for one in processes if "stdin.buffer" in " ".join(one["cmdline"] or ())]
    (found,) = [one for one in receivers if (one["environ"] or {}).get("HOME") == str(site.home)]
    return int(found["pid"])


def test_what_is_left_of_an_unfinished_release_is_removed(site: Site):
    site.sync(brought(a="1"))
    partial = site.workspace / "releases/000002-12345678.partial"
    (partial / "lib").mkdir(parents=True)

    site.sync(brought(a="2"))

    assert not partial.exists()


def test_an_operator_waits_for_another_and_is_told_for_whom(site: Site):
    site.sync(brought(a="1"))
    with open(site.workspace / ".lock", "r+") as lock:
        lock.write("ann on laptop, since 12:00")
        lock.truncate()
        fcntl.flock(lock, fcntl.LOCK_EX)
        results: list[SyncOutcome] = []
        waiting = threading.Thread(target=lambda: results.append(site.sync(brought(a="2"))))
        waiting.start()
        wait_until(lambda: bool(site.messages), "it says so")
        assert site.messages == ["waiting for ann on laptop, since 12:00, who synchronizes it"]
    waiting.join(60)
    assert results[0].is_changed


def test_two_operators_at_once_bring_one_release_each_in_turn(tmp_path: Path):
    site = Site(tmp_path / "bot")
    files = [brought(a=str(n)) for n in range(3)]
    threads = [threading.Thread(target=site.sync, args=(one,)) for one in files]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)

    assert len(site.releases) == 3
    assert (site.current / "a").read_text() in "012"
