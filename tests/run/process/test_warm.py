"""Python programs that are started warm: what can be seen of them is what is seen of cold ones."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from launcher.run.stacks import py_spy
from tests.support.benches import Bench
from tests.support.repository import REPOSITORY

PROBE = REPOSITORY / "tests/support/warm_probe.py"

PROBES = """
    ExecuteProcess(cmd=[sys.executable, "{probe}", "{out}/script"], output="screen"),
    ExecuteProcess(cmd=[sys.executable, "warm_probe.py", "{out}/terminal"], cwd="{folder}",
                   output="own_log", emulate_tty=True),
    ExecuteProcess(cmd=[sys.executable, "-m", "warm_probe", "{out}/module", "--flag"],
                   cwd="{folder}", output="screen"),
    ExecuteProcess(cmd=["{folder}/console", "{out}/console", "a b", ""], output="both",
                   additional_env={{"GREETING": "grüße", "EMPTY": ""}}),
"""
LIMITED = ["--nice", "console*=7", "--cpus", "console*=0", "--limit", "console*:nofile=200/300"]
CONSOLE = """#!{python}
import sys
from warm_probe import main
if __name__ == '__main__':
    sys.exit(main())
"""


@pytest.fixture
def programs(tmp_path: Path) -> Path:
    """The probe in a folder of its own, with a console script for it."""
    folder = tmp_path / "programs"
    folder.mkdir()
    (folder / "warm_probe.py").write_text(PROBE.read_text())
    (folder / "console").write_text(CONSOLE.format(python=sys.executable))
    (folder / "console").chmod(0o755)
    return folder


def facts_of(bench: Bench, folder: Path, how: str) -> tuple[dict[str, Any], str]:
    """(probe -> its facts, the screen) of a run with `--warm` or `--cold`."""
    out = bench.folder / "out"
    out.mkdir(exist_ok=True)
    actions = PROBES.format(probe=f"{folder}/warm_probe.py", folder=folder, out=out)
    bench.env[py_spy.VARIABLE] = py_spy.find() or ""  # usable: then a node need not tell its stacks
    done = bench.run(actions, how, *LIMITED)
    facts = {}
    for name in ("script", "terminal", "module", "console"):
        facts[name] = json.loads((out / name).read_text())
        (out / name).unlink()
        for variables in ("variables", "variables_in_c"):
            for varying in ("LAUNCHER_RUN_ID", "ROS_LOG_DIR", "LD_LIBRARY_PATH"):
                assert facts[name][variables].pop(varying)
        entries = facts[name].pop("environment").split("\0")
        facts[name]["environment"] = [e for e in entries if not _varies(e)]
        assert len(entries) > len(facts[name]["environment"])
    return facts, done.stdout.decode()


def _varies(entry: str) -> bool:
    return entry.startswith(("LAUNCHER_RUN_ID=", "ROS_LOG_DIR=", "LD_LIBRARY_PATH="))


def test_a_warm_process_sees_what_a_cold_one_sees(bench: Bench, programs: Path):
    cold, cold_screen = facts_of(bench, programs, "--cold")
    warm, warm_screen = facts_of(bench, programs, "--warm")
    for probe, facts in cold.items():
        assert {k: v for k, v in warm[probe].items() if facts[k] != v} == {}, probe
    assert cold["console"]["nice"] - cold["script"]["nice"] == 7
    assert warm["console"]["rlimits"][7] == [200, 300]
    assert (
        cold_screen.count("\n[python-1] at exit") == warm_screen.count("\n[python-1] at exit") == 1
    )
    random = re.findall(r"\] random: (\S+) (\S+) (\S+) (\S+)", warm_screen)
    assert len(random) == 3
    assert len({number for numbers in random for number in numbers}) == 12


# ---- how they end

ENDS = {
    "exit_code": "import sys\nsys.exit(3)",
    "exit_text": "import sys\nsys.exit('that was it')",
    "exit_none": "print('no newline', end='')\nraise SystemExit",
    "error": "def inner():\n    1 / 0\n\ndef outer():\n    inner()\n\nouter()",
    "cause": "try:\n    1 / 0\nexcept Exception as e:\n    raise ValueError('so') from e",
    "interrupt": "raise KeyboardInterrupt",
    "syntax": "x = (\n",
    "no_module": "import no_such_module",
    "bad_module": "import bad_module",
    "hook": "import sys\nsys.excepthook = lambda *a: print('hook', a[0], a[2].tb_lineno)\n1 / 0",
    "bad_hook": "import sys\nsys.excepthook = lambda *a: 1 / 0\n{}['a']",
    "killed": "import os, signal\nos.kill(os.getpid(), signal.SIGTERM)\nsignal.pause()",
    "at_once": "import os\nprint('left')\nos._exit(4)",
    "abort": "import os, faulthandler\nfaulthandler.enable()\nos.abort()",
    "at_exit": "import atexit\natexit.register(print, 'at exit')\nprint('first')",
    "thread": "import threading, time\n"
    "def late():\n    time.sleep(0.1)\n    print('thread')\n"
    "threading.Thread(target=late).start()\nprint('main')",
    "fork": "import os\npid = os.fork()\n"
    "if not pid:\n    print('child', os.getsid(0) == os.getppid())\n    raise SystemExit(5)\n"
    "print('parent', os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))",
    "warning": "import warnings\nwarnings.warn('look')",
    "processes": "import multiprocessing as mp, os\n"
    "def square(x):\n    return x * x\n\n"
    "if __name__ == '__main__':\n"
    "    for how in ('spawn', 'fork', 'forkserver'):\n"
    "        with mp.get_context(how).Pool(2) as pool:\n"
    "            print(how, pool.map(square, [1, 2, 3]))",
    "pool": "from concurrent.futures import ProcessPoolExecutor\n"
    "if __name__ == '__main__':\n"
    "    with ProcessPoolExecutor(2) as pool:\n        print(sorted(pool.map(abs, [-1, -2])))",
    "pickled": "import pickle\nclass A:\n    x = 1\n"
    "print(pickle.loads(pickle.dumps(A())).x, pickle.dumps(A)[:30])",
    "subprocess": "import subprocess, sys\n"
    "print(subprocess.check_output([sys.executable, '-c', 'print(6 * 7)'], text=True))",
    "stdin": "import sys, select\nprint(select.select([sys.stdin], [], [], 0))",
    "streams": "import sys\nsys.stderr.write('a')\nsys.stdout.write('b\\n')\nprint('c')",
    "shadow": "import queue\nprint(queue.mine)",
    "asyncio": "import asyncio, threading\n"
    "async def f():\n    return await asyncio.to_thread(threading.active_count)\n"
    "print(asyncio.run(f()))",
}
NO_PREFIX = re.compile(r"^\[(\w+-\d+)\] (.*)$")
END = re.compile(r"^\[\w+\] \[(\w+-\d+)\]: (process has .*)$")


def ends_of(bench: Bench, folder: Path, how: str) -> dict[str, list[str]]:
    """Process -> what it wrote, and how it ended."""
    started = ", ".join(
        f'ExecuteProcess(cmd=[sys.executable, "{folder}/{name}/main.py"], name="{name}", '
        'output="screen")'
        for name in ENDS
    )
    done = bench.run(started, how)
    found: dict[str, list[str]] = {}
    for line in done.stdout.decode().splitlines():
        match = NO_PREFIX.match(line) or END.match(line)
        # faulthandler shows all frames, also those from which the program was called.
        if match is not None and "/launcher/run/warm/" not in line:
            text = re.sub(r"pid \d+|0x[0-9a-f]+", "", match[2])
            found.setdefault(match[1], []).append(text)
    return found


def test_a_warm_process_ends_as_a_cold_one_does(bench: Bench, tmp_path: Path):
    for name, text in ENDS.items():
        folder = tmp_path / "ends" / name
        folder.mkdir(parents=True)
        (folder / "main.py").write_text(text + "\n")
        (folder / "bad_module.py").write_text("x = 1\nraise RuntimeError('bad')\n")
    (tmp_path / "ends/shadow/queue.py").write_text("mine = True\n")
    cold = ends_of(bench, tmp_path / "ends", "--cold")
    warm = ends_of(bench, tmp_path / "ends", "--warm")
    assert set(cold) == set(warm)
    assert {name: lines for name, lines in warm.items() if cold[name] != lines} == {}
    assert len(cold) == len(ENDS)
    interrupted = next(lines for name, lines in warm.items() if name.startswith("interrupt-"))
    assert "exit code -2" in interrupted[-1]
