"""`attach` where no host needs to be asked."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def test_it_needs_no_secret(tmp_path: Path):
    secret = "environment: {TOKEN: {from_environment: NOT_SET_ANYWHERE}}"
    text = f"hosts: {{bot1: {{address: 127.0.0.1, engine: ssh, {secret}}}}}\n"
    (tmp_path / "hosts.yaml").write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "launcher", "attach", "--list"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (done.stdout, done.returncode) == ("no runs\n", 0), done.stderr
