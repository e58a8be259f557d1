"""All hosts are synchronized at the same time."""

from __future__ import annotations

import contextlib
import functools
import os
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed

from launcher.base.errors import LauncherError
from launcher.hosts.failures import no_ssh
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.ssh import SshConnection, ssh_environment
from launcher.hosts.sync.host_sync import HostSync, SyncOptions, SyncOutcome
from launcher.hosts.sync.natives import natives
from launcher.hosts.sync.release_tree import Release
from launcher.hosts.sync.sync_session import SyncSession, script
from launcher.hosts.sync.synced_packages import Brought

_MOST_AT_ONCE = 32

Result = SyncOutcome | LauncherError


class FleetSync:
    """`words` makes the command that runs a script on a host: by ssh, unless a test says so.

    `done` is called, in the thread of the caller, when a host is done. If it raises OSError, all
    others are done before that is raised; with any other exception they are given up, and `done`
    is called for those that were done meanwhile.
    """

    def __init__(
        self,
        options: SyncOptions,
        say: Callable[[str, str], None],
        words: Callable[[Host, str], Sequence[str]] | None = None,
        done: Callable[[Host, Result], None] = lambda *_: None,
    ) -> None:
        self._options = options
        self._say = say
        self._words = words or _by_ssh
        self._done = done
        self._sessions: set[SyncSession] = set()
        self._guard = threading.Lock()
        self._is_stopped = False

    def sync(self, hosts: Sequence[Host], brought: Brought) -> list[Result]:
        """Bring what is here to the hosts; OSError if a file here cannot be read."""
        release = Release(list(brought.tree.entries.values()))
        compiled = natives(brought.tree.entries.values())
        return self._for_all(hosts, lambda sync: sync.run(release, compiled))

    def roll_back(self, hosts: Sequence[Host]) -> list[Result]:
        """Have the hosts use the releases that they used before."""
        return self._for_all(hosts, lambda sync: sync.roll_back())

    def _for_all(
        self, hosts: Sequence[Host], do: Callable[[HostSync], SyncOutcome]
    ) -> list[Result]:
        with ThreadPoolExecutor(min(len(hosts), _MOST_AT_ONCE) or 1) as pool:
            futures = {pool.submit(self._for_one, host, do): host for host in hosts}
            open_ones = dict(futures)
            try:
                errors = self._report(as_completed(futures), open_ones)
            except BaseException:
                over = {future for future in open_ones if future.done()}
                self._stop()
                pool.shutdown()
                ended = [one for one in open_ones if one.exception() is None]
                done = [
                    one for one in ended if one in over or isinstance(one.result(), SyncOutcome)
                ]
                self._report(done, open_ones)
                raise
            if errors:
                raise errors[0]
            return [future.result() for future in futures]

    def _report(
        self, ended: Iterable[Future[Result]], open_ones: dict[Future[Result], Host]
    ) -> list[OSError]:
        """Call `done` for each, which is no longer open; its errors."""
        errors = []
        for future in ended:
            host, result = open_ones.pop(future), future.result()
            try:
                self._done(host, result)
            except OSError as error:
                errors.append(error)
        return errors

    def _for_one(self, host: Host, do: Callable[[HostSync], SyncOutcome]) -> Result:
        begin = time.monotonic()
        try:
            session = self._opened(host)
        except FileNotFoundError:
            return no_ssh(host)
        except LauncherError as error:
            return error
        try:
            session.start()
            say = functools.partial(self._say_there, host.name)
            return do(HostSync(host, session, self._options, say, begin))
        except LauncherError as error:
            return error
        finally:
            with self._guard:
                self._sessions.discard(session)
            session.close()

    def _say_there(self, name: str, text: str) -> None:
        with contextlib.suppress(OSError):  # a host is done also if nobody reads
            self._say(name, text)

    def _opened(self, host: Host) -> SyncSession:
        words = self._words(host, script(host))
        with self._guard:
            if self._is_stopped:
                raise LauncherError("interrupted")
            session = SyncSession(host, words, ssh_environment(os.environ))
            self._sessions.add(session)
        return session

    def _stop(self) -> None:
        """End all sessions; hosts keep the releases that they use."""
        with self._guard:
            self._is_stopped = True
            for session in self._sessions:
                session.kill()


def _by_ssh(host: Host, text: str) -> Sequence[str]:
    return SshConnection(host, None).session(text)
