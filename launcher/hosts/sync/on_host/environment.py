"""Makes environments of Python: by pip from the network of the host, or from wheels sent to it."""

from __future__ import annotations

import errno
import glob
import os
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence

from launcher.hosts.sync.on_host import pip_messages
from launcher.hosts.sync.on_host.store import HostStore, Refusal, disk_errors, remove_folder

_COMPLETE = "launcher-complete"  # written last: without it the folder is removed
_DEBIAN = "/usr/share/python-wheels"  # where Debian keeps the wheel of pip
_PIP = ("--disable-pip-version-check", "--no-input", "--quiet", "--retries=1")


def complete(workspace: HostStore, key: str) -> str | None:
    """The newest complete environment for a key: `KEY`, or `KEY.2` that was made again."""
    found = [name for name in _names(workspace, key) if _is_complete(workspace, name)]
    return found[-1] if found else None


def make(workspace: HostStore, key: str, requirements: str, wheels: Sequence[str] | None) -> str:
    """A new environment; its name. `wheels` are files in `wheels/`; None: pip downloads.

    It is made where it stays, since scripts in it have its path. Refusal.
    """
    for name in _names(workspace, key):
        if not _is_complete(workspace, name):
            remove_folder(os.path.join(workspace.venvs, name))
    taken = _names(workspace, key)
    name = key if not taken else f"{key}.{_number(taken[-1]) + 1}"
    folder = os.path.join(workspace.venvs, name)
    with disk_errors(workspace):
        try:
            _run([sys.executable, "-I", "-m", "venv", "--without-pip", folder], "venv failed")
            _install(folder, requirements, wheels, workspace)
            with open(os.path.join(folder, _COMPLETE), "w", encoding="utf-8") as file:
                file.write(requirements)
        except BaseException:
            remove_folder(folder)
            raise
    return name


def _names(workspace: HostStore, key: str) -> list[str]:
    if not os.path.isdir(workspace.venvs):
        return []
    found = [name for name in os.listdir(workspace.venvs) if name.partition(".")[0] == key]
    return sorted(found, key=_number)


def _number(name: str) -> int:
    return int(name.partition(".")[2] or 1)


def _is_complete(workspace: HostStore, name: str) -> bool:
    return os.path.isfile(os.path.join(workspace.venvs, name, _COMPLETE))


def _install(
    folder: str, requirements: str, wheels: Sequence[str] | None, workspace: HostStore
) -> None:
    python = os.path.join(folder, "bin/python")
    if wheels is None:
        words = ["-r", "/dev/stdin"]
    else:
        files = [os.path.join(workspace.wheels, name) for name in wheels]
        words = ["--no-index", "--no-deps", *files]
    if wheels != []:
        pip = _pip(python, workspace)
        _run([*pip, "install", *_PIP, *words], "pip failed", requirements)


def _pip(python: str, workspace: HostStore) -> list[str]:
    """The words that run some pip for the environment; Refusal if the host has none."""
    files = glob.glob(os.path.join(workspace.wheels, "pip-*.whl"))
    try:
        import ensurepip

        files += glob.glob(os.path.join(os.path.dirname(ensurepip.__file__), "_bundled/pip-*.whl"))
    except ImportError:
        pass
    files += glob.glob(os.path.join(_DEBIAN, "pip-*.whl"))
    if files:
        return [python, "-I", os.path.join(files[0], "pip")]
    has_pip = [sys.executable, "-I", "-m", "pip", "--version"]
    if subprocess.run(has_pip, stdin=subprocess.DEVNULL, capture_output=True).returncode == 0:
        return [sys.executable, "-I", "-m", "pip", "--python", python]
    raise Refusal(
        f"{sys.executable} has neither ensurepip nor pip",
        "install them there (Debian, Ubuntu: apt install python3-venv), or put a wheel of pip "
        "into the wheelhouse",
    )


def _run(command: Sequence[str], what: str, given: str = "") -> None:
    env = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    # The wheels of ROS execute Python again where this is not set.
    env["_ROS_WHEELS_BOOTSTRAP_COMPLETE"] = "1"
    done = subprocess.Popen(
        list(command),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env=env,
        close_fds=False,  # it holds the lock, too
        start_new_session=True,
    )
    threading.Thread(target=_end_with_operator, args=(done,), daemon=True).start()
    output, _ = done.communicate(given.encode("utf-8", "surrogateescape"))
    if done.returncode == 0:
        return
    lines = output.decode(errors="replace").strip().splitlines()
    text = "\n".join(lines[-6:]) or f"exit code {done.returncode}"
    if "No space left on device" in text:
        raise OSError(errno.ENOSPC, "No space left on device")
    if pip_messages.is_offline("\n".join(lines)):
        raise Refusal(
            "pip reaches no index of packages from there",
            "give --wheelhouse DIR, which may be a new folder: it is filled here, and sent",
        )
    if name := pip_messages.missing(text):
        version = f"Python {sys.version_info.major}.{sys.version_info.minor}"
        text = f"it finds no {name} for {version} on {os.uname().machine}"
    raise Refusal(f"{what}: {text}", pip_messages.advice("\n".join(lines)))


def _end_with_operator(process: subprocess.Popen[bytes]) -> None:
    """Kill the program, and what it has started, when nobody sends requests any more."""
    waiting = select.poll()
    waiting.register(0, select.POLLRDHUP)
    while process.poll() is None:
        for _, events in waiting.poll(500):
            if events & (select.POLLHUP | select.POLLRDHUP) and process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            return
