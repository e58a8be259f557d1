"""Scripts for a host with systemd in a real shell; what needs systemd itself fails there."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

from launcher.engine.hosts.systemd.facts import Facts
from launcher.engine.hosts.systemd.scripts import Scripts
from launcher.hosts.model import Host
from launcher.hosts.order import Order


def facts(folder: Path, **fields: object) -> Facts:
    known = {
        "uid": 0,
        "user": "me",
        "home": str(folder),
        "runtime": str(folder),
        "version": 252,
        "state": "running",
        "lingers": True,
        "boot_id": "b",
        "uptime_s": 1.0,
        "cursor": None,
        "has_launcher": True,
        "python": sys.executable,
    }
    return Facts(**{**known, **fields})  # type: ignore[arg-type]


def shell(script: str, folder: Path, **options: object) -> subprocess.CompletedProcess[bytes]:
    env = {"PATH": os.environ["PATH"], "HOME": str(folder)}
    words = ["/bin/sh", "-c", script] if len(script) < 100_000 else ["/bin/sh"]
    return subprocess.run(words, cwd=folder, env=env, capture_output=True, **options)  # type: ignore[call-overload,no-any-return]


def ran(scripts: Scripts, order: Order, folder: Path) -> str:
    """What a process writes that is started with its script, as its unit does."""
    shell(scripts.prepare(), folder)
    assert shell(scripts.files(1, order), folder).returncode == 0
    done = shell(f"exec /bin/sh {scripts.folder}/1/start", folder)
    assert done.returncode == 0, done.stderr
    return done.stdout.decode()


def test_variables_whose_names_no_shell_takes_arrive(tmp_path: Path):
    values = {"A.B": "it's\n$(id)", "x-y": "gr\udcffün", "PLAIN": "\x01"}
    words = ((sys.executable,), ("-c",), ("import json, os; print(json.dumps(dict(os.environ)))",))
    order = Order(name="a-1", label="a", words=words, environment=values, merge=True)

    scripts = Scripts("k3", Host("bot1", "b"), facts(tmp_path))
    found = json.loads(ran(scripts, order, tmp_path))

    assert {name: found.get(name) for name in values} == values
