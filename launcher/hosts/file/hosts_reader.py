"""Reads a hosts file; all mistakes are reported at once, with their lines."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator, Mapping
from typing import Any

from launcher.base import text_file
from launcher.base.document.document_reader import (
    BAD,
    DocumentReader,
    TextLoader,
    meant_names,
    text_of,
    together,
)
from launcher.base.document.fields import near
from launcher.base.errors import LaunchFileError
from launcher.base.model.record import replace
from launcher.hosts.file.discovery_field import DISCOVERY
from launcher.hosts.file.host_fields import HOST_FIELDS, HOST_NAME, NOT_DEFAULT
from launcher.hosts.file.hosts_model import (
    LOCAL,
    Discovery,
    Host,
    HostEngine,
    HostsFile,
    Rule,
    Secret,
)
from launcher.hosts.file.pattern import ProcessPattern
from launcher.hosts.file.ssh_options import trusts_each_time

TOP_KEYS = ("defaults", "hosts", "place", "discovery")
_KINDS_OF_PYTHON = ("python", "venv")


def read(
    path: str, environ: Mapping[str, str] | None = None, *, with_secrets: bool = True
) -> HostsFile:
    """The hosts file; LauncherError (exit code 2) with all its mistakes.

    `environ` is the operator's environment, for secrets (default: `os.environ`). With
    `with_secrets` False their values are empty, and need not be there: for plans.
    """
    return parse(text_of(path, "the hosts file"), path, environ, with_secrets=with_secrets)


def parse(
    text: str,
    path: str,
    environ: Mapping[str, str] | None = None,
    *,
    with_secrets: bool = True,
) -> HostsFile:
    """As `read`, of a text; `path` is for places and for relative paths in it."""
    environment = os.environ if environ is None else environ
    return _HostsReader(text, path, environment if with_secrets else None).hosts_file()


class _HostsReader(DocumentReader):
    """`environ` None: values of secrets are not looked up."""

    def __init__(self, text: str, path: str, environ: Mapping[str, str] | None) -> None:
        super().__init__(
            text, path, what="a hosts file", hint="it begins with 'hosts:'", loader=TextLoader
        )
        self._environ = environ
        self._warnings: list[str] = []

    def hosts_file(self) -> HostsFile:
        document = self.document()
        if document is None and not self.errors:
            hint = "as in 'hosts: {bot1: {address: 10.0.0.2}}'"
            raise LaunchFileError("the hosts file is empty", where=self.path, hint=hint)
        document = document or {}
        if not self.errors or document:
            self._check_keys(document)
        hosts = {host.name: host for host in self._hosts(document)}
        rules = tuple(self._rules(document.get("place")))
        self._check_targets(rules, document.get("hosts"))
        discovery = self._discovery(document)
        if self.errors:
            raise together(self.errors)
        return HostsFile(
            path=self.path,
            hosts=hosts,
            rules=rules,
            warnings=tuple(self._warnings),
            discovery=discovery,
        )

    def hint_of(self, error: Exception, line: str, column: int, message: str) -> str | None:
        found = re.search(r"\*[^:\s,}]*", line[max(0, column - 2) :])
        about = f"{message} {getattr(error, 'context', '')}"
        if found is not None and ("alias" in about or "alphabetic" in about):
            return f"what begins with '*' needs quotes: \"{found[0]}\""
        return super().hint_of(error, line, column, message)

    def _check_keys(self, document: Mapping[object, object]) -> None:
        for key in document:
            if key not in TOP_KEYS:
                message = f"unknown key '{key}' of a hosts file"
                self.wrong((key,), message, near(key, TOP_KEYS))
        if not document.get("hosts") and "hosts" not in map(str, document):
            self.wrong((), "a hosts file needs 'hosts'", "as in 'bot1: {address: 10.0.0.2}'")

    # ---- hosts

    def _hosts(self, document: Mapping[object, object]) -> Iterator[Host]:
        defaults = self._defaults(document.get("defaults"))
        hosts = document.get("hosts")
        if "hosts" not in document:
            return
        if not isinstance(hosts, Mapping) or not hosts:
            hint = "as in 'bot1: {address: 10.0.0.2}'"
            self.wrong(("hosts",), "'hosts' must be a mapping of names to hosts", hint)
            return
        for name, entry in hosts.items():
            is_name = self._is_host_name(name)
            host = None if name == LOCAL else self._host(str(name), entry, defaults)
            if is_name and host is not None:
                yield host

    def _defaults(self, value: object) -> dict[str, Any]:
        if value is None:
            return {}
        if not isinstance(value, Mapping):
            self.wrong(("defaults",), "'defaults' must be a mapping", "as in {user: robot}")
            return {}
        known = [field for field in HOST_FIELDS if field.name not in NOT_DEFAULT]
        values = self.fields(value, known, ("defaults",), "'defaults'")
        self._check_python(values, ("defaults",))
        return values

    def _is_host_name(self, name: object) -> bool:
        if name == LOCAL:
            text = f"'{LOCAL}' is the machine of the launcher, and needs no entry"
            self.wrong(("hosts", LOCAL), text)
            return False
        if not isinstance(name, str) or re.fullmatch(HOST_NAME, name) is None:
            hint = "letters, digits, '_', '-' and '.'"
            self.wrong(("hosts", name), f"'{name}' is not a name of a host", hint)
            return False
        return True

    def _host(self, name: str, entry: object, defaults: Mapping[str, Any]) -> Host | None:
        path = ("hosts", name)
        if isinstance(entry, str):
            address = self.parsed(HOST_FIELDS[0].type, entry, path)
            own = {} if address is BAD else {"address": address}
            names: Mapping[object, object] = {"address": entry}
        elif isinstance(entry, Mapping):
            own = self.fields(entry, HOST_FIELDS, path, f"host '{name}'")
            names = entry
        else:
            hint = f"as in '{name}: {{address: 10.0.0.2}}'"
            self.wrong(path, f"host '{name}' must be a mapping, or its address", hint)
            return None
        if "address" not in {*names, *meant_names(names, ["address"])}:
            hint = f"as in '{name}: {{address: 10.0.0.2}}'"
            self.wrong(path, f"host '{name}' needs an address", hint)
        self._check_python(own, path)
        if "address" not in own:
            return None
        return self._made(name, _merged(defaults, own), path)

    def _check_python(self, values: dict[str, Any], path: tuple[object, ...]) -> None:
        if all(key in values for key in _KINDS_OF_PYTHON):
            hint = "a virtual environment contains a Python interpreter"
            self.wrong((*path, "venv"), "'python' and 'venv' exclude each other", hint)

    def _made(self, name: str, values: dict[str, Any], path: tuple[object, ...]) -> Host:
        variables = dict(self._variables(values.get("environment", {}), path))
        setup = tuple(values.get("setup", ()))
        if "ros" in values:
            setup = (f"{values['ros'].rstrip('/')}/setup.sh", *setup)
        python = values.get("python", "python3")
        if "venv" in values:
            python = f"{values['venv'].rstrip('/')}/bin/python"
        ssh = values.get("ssh", {})
        if trusts_each_time(ssh):
            text = (
                "'accept-new' without a file of known hosts would trust any machine each time: "
                f"'{ssh['UserKnownHostsFile']}' keeps nothing"
            )
            hint = "let 'UserKnownHostsFile' name a file that can be written, or leave it out"
            self.wrong((*path, "ssh"), text, hint)
        return Host(
            name=name,
            address=values["address"],
            user=values.get("user"),
            engine=HostEngine(values.get("engine", "auto")),
            ssh={key: os.path.expanduser(text) for key, text in ssh.items()},
            python=python,
            setup=setup,
            environment=variables,
            secrets={
                key: self._absolute(value)
                for key, value in values.get("environment", {}).items()
                if isinstance(value, Secret)
            },
            on_link_loss=values.get("on_link_loss"),
            workspace=values.get("workspace", Host.workspace),
            node_selector=values.get("node_selector", {}),
            where=str(self.source.origin(path)),
        )

    # ---- values of variables

    def _variables(
        self, variables: Mapping[str, str | Secret], path: tuple[object, ...]
    ) -> Iterator[tuple[str, str]]:
        for name, value in variables.items():
            if isinstance(value, str):
                yield name, value
            elif self._environ is None:
                yield name, ""
            else:
                text = self._secret(self._absolute(value), (*path, "environment", name))
                if text is not None:
                    yield name, text

    def _absolute(self, secret: Secret) -> Secret:
        if secret.file is None:
            return secret
        folder = os.path.dirname(os.path.abspath(self.path))
        return Secret(file=os.path.join(folder, os.path.expanduser(secret.file)))

    def _secret(self, secret: Secret, path: tuple[object, ...]) -> str | None:
        assert self._environ is not None
        if secret.variable is not None:
            text = self._environ.get(secret.variable)
            if text is None:
                hint = f"set it for the launcher: {secret.variable}=... launcher ..."
                message = f"the environment has no variable '{secret.variable}'"
                self.wrong(path, message, hint, value=True)
            return text
        assert secret.file is not None
        try:
            return self._content(secret.file)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
            self.wrong(path, f"cannot read '{secret.file}': {reason}", value=True)
            return None

    def _content(self, path: str) -> str:
        text = text_file.read(path).rstrip("\n")
        if stat.S_IMODE(os.stat(path).st_mode) & 0o077:
            self._warnings.append(f"{path} can be read by others: chmod 600 {path}")
        if "\0" in text:
            raise ValueError
        return text

    # ---- rules

    def _rules(self, value: object) -> Iterator[Rule]:
        if value is None:
            return
        if not isinstance(value, Mapping):
            hint = "as in 'robot_1: bot1'"
            self.wrong(("place",), "'place' must be a mapping of patterns to hosts", hint)
            return
        for pattern, host in value.items():
            path = ("place", pattern)
            try:
                ProcessPattern.parse(pattern)
            except ValueError as error:
                self.wrong(path, str(error), getattr(error, "hint", None))
            if not isinstance(host, str) or not host:
                hint = f"a name of 'hosts', or {LOCAL}"
                self.wrong(path, "expected the name of one host", hint, value=True)
                continue
            yield self._rule(str(pattern), host)

    def _rule(self, pattern: str, host: str) -> Rule:
        place = self.source.error(("place", pattern), "")
        return Rule(
            pattern=pattern,
            host=host,
            where=place.where or "",
            source_line=place.source_line,
            column=place.column,
        )

    def _discovery(self, document: Mapping[object, object]) -> Discovery:
        given = document.get("discovery")
        found = Discovery() if given is None else self.parsed(DISCOVERY, given, ("discovery",))
        if given is None or found is BAD:
            return Discovery()
        hosts = document.get("hosts")
        known = list(dict.fromkeys([*(hosts if isinstance(hosts, Mapping) else ()), LOCAL]))
        for key, host in (("server", found.server), ("backup", found.backup)):
            if host is not None and host not in known:
                hint = near(host, list(map(str, known)))
                self.wrong(("discovery", key), f"unknown host '{host}'", hint, value=True)
        return replace(found, where=str(self.source.origin(("discovery",))))

    def _check_targets(self, rules: tuple[Rule, ...], hosts: object) -> None:
        if not isinstance(hosts, Mapping):
            return
        known = list(dict.fromkeys([*map(str, hosts), LOCAL]))
        for rule in rules:
            if rule.host not in known:
                path = ("place", rule.pattern)
                self.wrong(path, f"unknown host '{rule.host}'", near(rule.host, known), value=True)


def _merged(defaults: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Both; mappings by their keys."""
    merged = dict(defaults)
    if any(key in own for key in _KINDS_OF_PYTHON):
        for key in _KINDS_OF_PYTHON:
            merged.pop(key, None)
    for key, value in own.items():
        is_mapping = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = {**merged[key], **value} if is_mapping else value
    return merged
