"""The way to an agent by another command than ssh, as on this machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from launcher.hosts.failures import HostError, Problem, last_line
from launcher.hosts.file.hosts_model import Host


class CommandTransport:
    """In place of SshTransport: `words` with the arguments of `launcher agent` behind them."""

    def __init__(self, host: Host, words: Sequence[str], environment: Mapping[str, str]) -> None:
        self._host = host
        self._words = tuple(words)
        self.environment = environment

    def words(self, arguments: Sequence[str], *, is_again: bool) -> Sequence[str]:
        return (*self._words, *arguments)

    def failure(self, stderr: str, returncode: int | None) -> HostError:
        text = last_line(stderr) or f"exit code {returncode}"
        return HostError(self._host, Problem.OTHER, text)

    def absence(self, error: OSError) -> HostError:
        return HostError(self._host, Problem.NO_SSH, f"{self._words[0]}: {error.strerror}")
