"""A process that has cleared its environment and left its session is dead when the tests end."""

from __future__ import annotations

import subprocess
import sys

import pytest

# The memory of the orphan takes the kernel 0.1 s to free, and until then it is alive.
SCRIPT = """
import subprocess, sys
from launcher.posix import proc
from launcher.posix.cleanup import subreaper
from launcher.workspace.testing import job_runner as runner

orphan = "import time; memory = bytearray(400 << 20); print(flush=True); time.sleep(1000)"
parent = f'''
import subprocess, sys
orphan = subprocess.Popen(
    [sys.executable, "-c", {orphan!r}], env={{}}, start_new_session=True, stdout=subprocess.PIPE
)
orphan.stdout.readline()
print(orphan.pid)
'''
subreaper.become()
pid = int(subprocess.check_output([sys.executable, "-c", parent]))
assert proc.is_alive(pid)
runner._kill_orphans()
assert not proc.is_alive(pid)
"""


@pytest.mark.basic
def test_an_orphan_is_dead_when_the_tests_end():
    subprocess.run([sys.executable, "-c", SCRIPT], check=True, timeout=60)
