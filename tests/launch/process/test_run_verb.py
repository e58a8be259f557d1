"""`run`: the program takes the place of the launcher, and gets every signal itself."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = "#!/bin/sh\necho $$\nexec sleep 60\n"


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_to_run_is_one_to_the_program(signum: signal.Signals, tmp_path: Path):
    index = tmp_path / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True)
    (index / "p").touch()
    program = tmp_path / "lib/p/wait"
    program.parent.mkdir(parents=True)
    program.write_text(PROGRAM, encoding="utf-8")
    program.chmod(0o755)
    with subprocess.Popen(
        [sys.executable, "-m", "launcher", "run", "p", "wait"],
        env={**os.environ, "AMENT_PREFIX_PATH": str(tmp_path), "HOME": str(tmp_path)},
        stdout=subprocess.PIPE,
        text=True,
    ) as run:
        assert run.stdout is not None
        assert run.stdout.readline() == f"{run.pid}\n"
        run.send_signal(signum)
        assert run.wait(60) == -signum
