"""The four ways to run a package of one's own: editable, installed, built by colcon, as sources."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import venv
from collections.abc import Mapping
from pathlib import Path

import pytest

from launcher.posix.domain_lease import leased_domain
from tests.support.own_package import write_package
from tests.support.repository import REPOSITORY


class Home:
    """An environment with the launcher and its dependencies, and packages of one's own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.python = folder / "bin" / "python"
        venv.create(folder)
        here = next(path for path in sys.path if path.endswith("site-packages"))
        below = folder / "lib" / Path(here).parent.name / "site-packages"
        (below / "launcher.pth").write_text(f"{REPOSITORY}\n{here}\n", encoding="utf-8")

    def install(self, source: Path, *options: str) -> None:
        command = [sys.executable, "-m", "pip", "--python", str(self.python), "install"]
        fixed = ["--quiet", "--no-index", "--no-deps", "--no-build-isolation", "--use-pep517"]
        self._run([*command, *fixed, *options, str(source)], source, {})

    def launcher(self, folder: Path, *words: str, **env: str) -> str:
        """The standard output of one command; it must succeed."""
        return self._run([str(self.python), "-m", "launcher", *words], folder, env)

    def _run(self, command: list[str], folder: Path, env: Mapping[str, str]) -> str:
        # `make` gives pip settings for the development of this project.
        left_out = ("AMENT_PREFIX_PATH", "PWD", "PIP_")
        usual = {k: v for k, v in os.environ.items() if not k.startswith(left_out)}
        usual["TMPDIR"] = str(self.folder.parent)
        done = subprocess.run(
            command,
            cwd=folder,
            env={**usual, **env},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=120,
        )
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
        return done.stdout


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Home:
    return Home(tmp_path_factory.mktemp("home") / "venv")


def check(home: Home, name: str, folder: Path, **env: str) -> None:
    """Everything that a launch file or a user asks about the package has an answer."""
    said = home.launcher(folder, "--no-log-files", name, f"{name}.launch.py", "who:=me", **env)
    assert "loaded: True" in said
    assert "same: True" in said
    assert said.count("node: there is p.yaml: True") == 2, said

    plan = json.loads(
        home.launcher(folder, "plan", "--json", name, f"{name}_xml.launch.xml", **env)
    )
    (process,) = plan["processes"]
    assert (process["package"], process["env_set"]) == (name, {})
    (parameters,) = process["parameters"]
    assert os.path.isfile(parameters["file"]), parameters
    assert os.access(process["cmd"][0], os.X_OK)

    assert "'who'" in home.launcher(folder, "args", name, f"{name}.launch.py", **env)
    alone = home.launcher(folder, "run", name, f"{name}_talker", "word", **env)
    assert alone == "node: there is p.yaml: True ['word']\n"


SAME, OTHER = "same-places", "other-places"  # of files in the source and in share


@pytest.mark.thorough
@pytest.mark.parametrize("moved", [False, True], ids=[SAME, OTHER])
def test_an_editable_package_is_used_from_its_source(home: Home, tmp_path: Path, moved: bool):
    name = f"editable_{moved}".lower()
    source = write_package(tmp_path / "src", name, moved=moved)
    home.install(source, "--editable")

    check(home, name, tmp_path)

    # A new file is there at once; if setup.py leaves it out, that is told.
    launch = source / ("files/starts" if moved else "launch")
    (launch / "new.launch.xml").write_text("<launch><log message='new file'/></launch>")
    assert "new file" in home.launcher(tmp_path, "--no-log-files", name, "new.launch.xml")


@pytest.mark.thorough
def test_an_installed_package_is_found_in_the_environment(home: Home, tmp_path: Path):
    name = "installed_pkg"
    home.install(write_package(tmp_path / "src", name))

    check(home, name, tmp_path)


PATHS = """
import launcher.api
from ros2pkg.api import get_executable_paths

for name in ("shared_one", "shared_two", "shared_three"):
    print(*get_executable_paths(package_name=name))
"""


@pytest.mark.thorough
def test_packages_that_name_a_script_alike_run_their_own(home: Home, tmp_path: Path):
    names = ("shared_one", "shared_two", "shared_three")
    for name, options in zip(names, [("--editable",), (), ("--editable",)], strict=True):
        source = write_package(tmp_path / "src", name)
        for file in ("setup.py", f"launch/{name}.launch.py", f"launch/{name}_xml.launch.xml"):
            text = (source / file).read_text().replace(f"{name}_talker", "talker")
            (source / file).write_text(text)
        (source / name / "talker.py").write_text("def main():\n    print('from', __name__)\n")
        home.install(source, *options)

    (tmp_path / "paths.py").write_text(PATHS)
    paths = home._run([str(home.python), "paths.py"], tmp_path, {}).splitlines()
    for name, path in zip(names, paths, strict=True):
        said = home.launcher(tmp_path, "--no-log-files", name, f"{name}.launch.py")
        assert said.count(f"from {name}.talker") == 2, said
        assert home.launcher(tmp_path, "run", name, "talker") == f"from {name}.talker\n"
        plan = home.launcher(tmp_path, "plan", "--json", name, f"{name}_xml.launch.xml")
        for program in (json.loads(plan)["processes"][0]["cmd"][0], path):
            assert home._run([program], tmp_path, {}) == f"from {name}.talker\n"


@pytest.mark.thorough
@pytest.mark.parametrize(
    "options",
    [(), ("--merge-install",), ("--symlink-install",)],
    ids=["isolated", "merged", "symlink"],
)
def test_a_package_of_a_sourced_workspace_is_found(home: Home, tmp_path: Path, options):
    name = "built_pkg"
    write_package(tmp_path / "src", name)
    colcon = Path(sys.executable).with_name("colcon")
    tools = {**os.environ, "PATH": f"{colcon.parent}:{os.environ['PATH']}"}
    home._run([str(colcon), "build", *options], tmp_path, tools)
    sourced = home._run(["sh", "-c", ". install/setup.sh && env -0"], tmp_path, {})
    env = dict(entry.split("=", 1) for entry in sourced.split("\0") if entry)

    # Away from the sources, which would be found as well.
    (tmp_path / "elsewhere" / "deep").mkdir(parents=True)
    wanted = ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH", "PYTHONPATH", "PATH")
    check(
        home,
        name,
        tmp_path / "elsewhere" / "deep",
        **{key: env[key] for key in wanted if key in env},
    )
    share = home.launcher(tmp_path, "plan", name, f"{name}.launch.py", **env)
    assert f"{tmp_path}/install" in share


@pytest.mark.parametrize(
    "moved",
    [pytest.param(False, id=SAME, marks=pytest.mark.thorough), pytest.param(True, id=OTHER)],
)
def test_a_package_that_is_not_installed_is_used_from_its_source(
    home: Home, tmp_path: Path, moved: bool
):
    name = f"sources_{moved}".lower()
    source = write_package(tmp_path / "ws" / "src", name, moved=moved)
    beside = write_package(tmp_path / "ws" / "src", "neighbour")

    check(home, name, beside)
    for folder in (tmp_path / "ws", source, source / name):
        said = home.launcher(folder, "--no-log-files", name, f"{name}_xml.launch.xml")
        assert "node: there is p.yaml: True" in said


def test_a_program_that_is_not_installed_imports_the_packages_it_depends_on(
    home: Home, tmp_path: Path
):
    write_package(tmp_path, "library_pkg")
    (tmp_path / "library_pkg/library_pkg/words.py").write_text("HELLO = 'from the library'\n")
    user = write_package(tmp_path, "user_pkg", depends="<depend>library_pkg</depend>")
    text = "from library_pkg.words import HELLO\n\n\ndef main():\n    print(HELLO)\n"
    (user / "user_pkg" / "talker.py").write_text(text)

    assert home.launcher(tmp_path, "run", "user_pkg", "user_pkg_talker") == "from the library\n"


SCRIPT = """
import launcher.api
from ros2launch.api import get_share_file_path_from_package, launch_a_launch_file
from ros2pkg.api import get_executable_paths

(program,) = get_executable_paths(package_name="script_pkg")
path = get_share_file_path_from_package(package_name="script_pkg", file_name="script_pkg.launch.py")
code = launch_a_launch_file(launch_file_path=path, launch_file_arguments=["who:=me"])
print(program.rpartition("/")[2], code)
"""


def test_a_script_launches_its_package_by_ros2launch(home: Home, tmp_path: Path):
    write_package(tmp_path, "script_pkg")
    (tmp_path / "script.py").write_text(SCRIPT)

    said = home._run([str(home.python), "script.py"], tmp_path, {})

    assert said.count("node: there is p.yaml: True") == 2
    assert said.endswith("script_pkg_talker 0\n")


@pytest.mark.thorough
def test_a_package_of_pkg_create_runs_at_once_and_editable(home: Home, tmp_path: Path):
    words = ("pkg", "create", "--build-type", "ament_python", "fresh", "--node-name", "talker")
    home.launcher(tmp_path, *words)
    assert runs(home, tmp_path, "run", "fresh", "talker")
    home.install(tmp_path / "fresh", "-e")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    assert home.launcher(elsewhere, "pkg", "executables", "fresh") == "fresh talker\n"
    assert home.launcher(elsewhere, "pkg", "xml", "fresh", "-t", "name") == "fresh\n"
    assert runs(home, elsewhere, "run", "--prefix", "env", "fresh", "talker")
    assert runs(home, elsewhere, "--no-log-files", "fresh", "fresh.launch.py")


def runs(home: Home, folder: Path, *words: str) -> bool:
    """Whether the node of `pkg create` says that it publishes; it is stopped then."""
    with leased_domain() as domain_id:
        env = {name: value for name, value in os.environ.items() if name != "AMENT_PREFIX_PATH"}
        env |= {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        with subprocess.Popen(
            [str(home.python), "-m", "launcher", *words],
            cwd=folder,
            env=env | {"ROS_LOG_DIR": str(folder), "TMPDIR": str(home.folder.parent)},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        ) as process:
            try:
                assert process.stdout is not None
                return any("Publishing a count" in line for line in process.stdout)
            finally:
                process.send_signal(signal.SIGINT)
