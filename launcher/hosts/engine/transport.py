"""How an agent is reached: the words of a process whose standard streams are its."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from launcher.hosts.failures import HostError, failure, no_ssh
from launcher.hosts.file.model import Host
from launcher.hosts.ssh import SshConnection, python_script, ssh_environment

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol

    class Transport(Protocol):
        """Makes processes that connect standard input and output with the agent."""

        # Of these processes.
        @property
        def environment(self) -> Mapping[str, str]: ...

        # `arguments` of `launcher agent`; `is_again`: what was used before may be broken.
        def words(self, arguments: Sequence[str], *, is_again: bool) -> Sequence[str]: ...

        # What a process has died of, before the agent has said anything.
        def failure(self, stderr: str, returncode: int | None) -> HostError: ...

        # The process cannot be started here.
        def absence(self, error: OSError) -> HostError: ...


class SshTransport:
    """By OpenSSH; a master connection of the user's own is used if there is one."""

    def __init__(self, host: Host, environment: Mapping[str, str]) -> None:
        self._host = host
        self._connection = SshConnection(host, None)
        self.environment = ssh_environment(environment)

    def words(self, arguments: Sequence[str], *, is_again: bool) -> Sequence[str]:
        script = python_script(self._host, ["-m", "launcher", "agent", *arguments])
        return self._connection.alone(script) if is_again else self._connection.session(script)

    def failure(self, stderr: str, returncode: int | None) -> HostError:
        return failure(self._host, stderr, returncode)

    def absence(self, error: OSError) -> HostError:
        return no_ssh(self._host)
