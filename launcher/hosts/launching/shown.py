"""Processes on other hosts in a plan: what runs there, without secrets."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launcher.base.model.record import Record
from launcher.hosts.discovery import BACKUP_NAME, SERVER_NAME
from launcher.hosts.file.hosts_model import LOCAL, Discovery, DiscoveryMode, Host
from launcher.hosts.file.order import Order
from launcher.hosts.file.order_words import FILES, folder_there, text_there, words_there
from launcher.hosts.file.references import Word
from launcher.launch.plan.plan_json import changed_variables
from launcher.launch.plan.shell_command import shell_word

if TYPE_CHECKING:
    from collections.abc import Mapping


class PlacedThere(Record):
    """A process on a host, with its order; without a host it runs on this machine."""

    host: Host | None = None
    order: Order | None = None

    @property
    def host_name(self) -> str:
        return LOCAL if self.host is None else self.host.name

    @property
    def is_here(self) -> bool:
        return self.host is None

    @property
    def shown(self) -> str:
        """`bot1`; `bot1 (skipped)` where it is not started."""
        is_skipped = self.host is not None and self.host.is_skipped
        return f"{self.host_name} (skipped)" if is_skipped else self.host_name

    def lines(
        self, environment: Mapping[str, str], env: Mapping[str, str]
    ) -> list[tuple[str, str]]:
        return lines_there(self, environment, env)

    def document(self, environment: Mapping[str, str], env: Mapping[str, str]) -> dict[str, Any]:
        return document_there(self, environment, env)


HERE = PlacedThere()


def command_there(host: Host, order: Order, given: Mapping[str, str]) -> str:
    """A line as in a shell on the host; `given` are the variables that the launch file sets."""
    parts = [f". {shell_word(path)} &&" for path in host.setup]
    folder = folder_there(order, host)
    parts += [] if folder is None else [f"cd {_quoted(folder)} &&"]
    variables = values_there(order, host, given)
    parts += ["env", *(f"{name}={_quoted(v)}" for name, v in variables.items())] * bool(variables)
    return " ".join([*parts, *map(_quoted, words_there(host, order))])


def _quoted(word: str) -> str:
    """Quoted for a shell, but what stands for something there stays readable."""
    return word if "<" in word and " " not in word.replace("<share of ", "") else shell_word(word)


def values_there(order: Order, host: Host, given: Mapping[str, str]) -> dict[str, str]:
    """The variables that the launch file sets, with their values there."""
    words: dict[str, Word] = {**{n: (v,) for n, v in order.environment.items()}, **order.variables}
    return {
        name: "".join(text_there(part, host) for part in words[name])
        for name in sorted(given)
        if name in words
    }


def names_there(placed: PlacedThere, given: Mapping[str, str]) -> list[str]:
    """The variables whose values are not shown: the operator's, and those of the hosts file."""
    assert placed.host is not None and placed.order is not None
    names = {*placed.order.environment, *placed.order.variables} - given.keys()
    return sorted(names | placed.host.environment.keys())


def lines_there(
    placed: PlacedThere, environment: Mapping[str, str], env: Mapping[str, str]
) -> list[tuple[str, str]]:
    """The lines below a process in the tree: the command, and what is sent with it."""
    host, order = placed.host, placed.order
    assert host is not None and order is not None
    given = changed_variables(env, environment)
    lines = [("command", f"$ {command_there(host, order, given)}")]
    names = names_there(placed, given)
    lines += [("aside", f"variables whose values are not shown: {', '.join(names)}")] * bool(names)
    for name, content in order.files.items():
        lines.append(("aside", f"{FILES}/{name}: sent, {len(content)} bytes"))
        if name.startswith("params") and name.endswith(".yaml"):
            text = _with_marks(order, content.decode(errors="replace"), host)
            lines += [("aside", f"  {line}") for line in text.splitlines()]
    return lines


def _with_marks(order: Order, text: str, host: Host) -> str:
    for mark, shared in order.marks.items():
        text = text.replace(mark, text_there(shared, host))
    return text


def document_there(
    placed: PlacedThere, environment: Mapping[str, str], env: Mapping[str, str]
) -> dict[str, Any]:
    """The entries of a process in the document of a plan with hosts."""
    host, order = placed.host, placed.order
    if host is None or order is None:
        return {"host": LOCAL, "skipped": False, "on_host": None}
    given = changed_variables(env, environment)
    return {
        "host": host.name,
        "skipped": host.is_skipped,
        "on_host": {
            "cmd": list(words_there(host, order)),
            "setup": list(host.setup),
            "cwd": folder_there(order, host),
            "env_set": values_there(order, host, given),
            "env_names": names_there(placed, given),
            "env_unset": list(order.unset),
            "files": [{"name": n, "bytes": len(data)} for n, data in order.files.items()],
        },
    }


# ---- discovery


def discovery_line(discovery: Discovery) -> str:
    """How the nodes find each other, and what is started for it."""
    match discovery.mode:
        case None:
            return ""
        case DiscoveryMode.MULTICAST:
            how = "ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET"
        case DiscoveryMode.PEERS:
            how = "ROS_STATIC_PEERS has the addresses of this machine and of the hosts"
        case DiscoveryMode.SERVER:
            servers = _servers(discovery)
            how = ", ".join(f"{name} on {host}" for name, host in servers.items())
    return f"discovery by {discovery.mode.value}: {how}"


def discovery_document(discovery: Discovery) -> dict[str, Any] | None:
    if discovery.mode is None:
        return None
    servers = _servers(discovery) if discovery.mode is DiscoveryMode.SERVER else {}
    return {"mode": discovery.mode.value, "servers": servers}


def _servers(discovery: Discovery) -> dict[str, str]:
    """Host by name of the process."""
    backup = {} if discovery.backup is None else {BACKUP_NAME: discovery.backup}
    return {SERVER_NAME: discovery.server, **backup}
