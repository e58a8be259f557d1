"""The program `bin/python` of a release."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from launcher.hosts.sync import release_python
from launcher.hosts.sync.release_tree import TreeEntry

NAMES = st.text(st.characters(blacklist_categories=["Cs"], blacklist_characters="\0/"), min_size=1)
PRINTS = """#!/bin/sh
printf '%s\\n' "$LAUNCHER_WORKSPACE" "$PYTHONPATH" "$0" "$@"
"""


def release(folder: Path, entry: TreeEntry, name: str = "000001-12345678") -> Path:
    """A release with this program; it can be started by the link `current`, too."""
    program = folder / "releases" / name / "bin/python"
    program.parent.mkdir(parents=True, exist_ok=True)
    program.unlink(missing_ok=True)
    program.write_bytes(entry.content or b"")
    program.chmod(0o755)
    if not (folder / "current").is_symlink():
        (folder / "current").symlink_to(f"releases/{name}")
    return folder / "releases" / name


def started(program: Path | str, *words: str, **variables: str) -> list[str]:
    env = {"PATH": "/usr/bin:/bin", **variables}
    return subprocess.run(
        [program, *words], env=env, capture_output=True, text=True, check=True
    ).stdout.split("\n")[:-1]


@pytest.fixture
def python(tmp_path: Path) -> str:
    path = tmp_path / "of the host"
    path.write_text(PRINTS)
    path.chmod(0o755)
    return str(path)


def test_the_release_is_in_front_of_what_is_set(tmp_path: Path, python: str):
    folder = release(tmp_path / "ü ws", release_python.of_host(python, python))

    found = started(folder.parents[1] / "current/bin/python", "a b", "", PYTHONPATH="/opt/ros")

    assert found == [str(folder), f"{folder}/lib:/opt/ros", python, "a b", ""]


def test_a_process_of_a_release_that_starts_it_again_adds_nothing(tmp_path: Path, python: str):
    folder = release(tmp_path / "ws", release_python.of_host(python, python))

    found = started(folder / "bin/python", PYTHONPATH=f"/x:{folder}/lib")

    assert found[1] == f"/x:{folder}/lib"


def test_that_of_an_environment_is_found_beside_the_releases(tmp_path: Path):
    workspace = tmp_path / "ws"
    folder = release(workspace, release_python.of_environment("abc.2"))
    own = workspace / "venvs/abc.2/bin/python"
    own.parent.mkdir(parents=True)
    own.write_text(PRINTS + 'printf "%s\\n" "$PATH"\n')
    own.chmod(0o755)

    found = started(workspace / "current/bin/python")

    assert found == [str(folder), f"{folder}/lib", str(own), f"{own.parent}:/usr/bin:/bin"]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(name=NAMES)
def test_the_name_of_a_program_is_no_command(tmp_path: Path, name: str):
    entry = release_python.of_host(name, "/usr/bin/false")
    script = (entry.content or b"").decode()
    line = script.splitlines(keepends=True)
    place = script.index("exec ")
    assert line[0] == "#!/bin/sh\n"

    done = subprocess.run(
        ["sh", "-c", "set -- x; printf '%s' " + script[place + 5 :]],
        capture_output=True,
        check=False,
        cwd=tmp_path,
    )

    assert done.stdout.decode(errors="surrogateescape") == name + "x"
    assert [*tmp_path.iterdir()] == []
