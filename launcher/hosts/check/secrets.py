"""Secrets of the hosts file that a run would not find on this machine; no value is read."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping

from launcher.base.model.level import Level
from launcher.hosts.check.facts import Finding, Member
from launcher.hosts.file.model import LOCAL, Secret


def missing_secrets(members: Iterable[Member], environ: Mapping[str, str]) -> Iterator[Finding]:
    """One finding for each secret, with the hosts that need it."""
    needed: dict[tuple[str, Secret], list[str]] = {}
    for member in members:
        for name, secret in (member.host.secrets if member.host else {}).items():
            needed.setdefault((name, secret), []).append(member.name)
    for (name, secret), hosts in needed.items():
        if not _is_there(secret, environ):
            text = f"{secret}, for {name}, is missing here, so that no run can start"
            repair = "create it" if secret.file else f"{secret.variable}=... launcher ..."
            yield Finding(
                check="secrets",
                hosts=(LOCAL, *hosts),
                level=Level.PROBLEM,
                text=text,
                advice=f"{repair}, or remove it from `environment` in the hosts file",
            )


def _is_there(secret: Secret, environ: Mapping[str, str]) -> bool:
    if secret.variable is not None:
        return secret.variable in environ
    return os.access(secret.file or "", os.R_OK)
