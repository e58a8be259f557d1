"""Workspaces that plain colcon has built: their environment is what their script makes."""

from __future__ import annotations

import contextlib
import json
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import pytest

from launcher.doctor.doctor_facts import WorkspaceFacts
from launcher.doctor.stale_workspace import inspect
from launcher.packages.distribution import ros_variables
from launcher.packages.workspace import Workspace
from tests.support.own_package import MANIFEST, write_package
from tests.workspace.unit.building.source_tree import interface_package, write

TOOLS = Path(sys.executable).parent
PATHS = ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH", "COLCON_PREFIX_PATH", "PYTHONPATH", "PATH")
BASE = """\
cmake_minimum_required(VERSION 3.10)
project({name} NONE)
find_package(ament_cmake REQUIRED)
install(FILES package.xml DESTINATION share/${{PROJECT_NAME}}/data)
install(PROGRAMS tool DESTINATION bin)
ament_environment_hooks(own.dsv.in)
{more}
ament_package()
"""


def write_cmake_package(parent: Path, name: str, more: str = "") -> Path:
    """A package that installs files and a hook that sets NAME_DATA and has libraries."""
    folder = parent / name
    folder.mkdir(parents=True)
    text = MANIFEST.format(name=name, depends="").replace("ament_python", "ament_cmake")
    (folder / "package.xml").write_text(text)
    (folder / "CMakeLists.txt").write_text(BASE.format(name=name, more=more))
    hooks = [
        f"set;{name.upper()}_DATA;share/{name}/data",
        "prepend-non-duplicate;LD_LIBRARY_PATH;lib",
    ]
    (folder / "own.dsv.in").write_text("\n".join(hooks))
    (folder / "tool").write_text("#!/bin/sh\necho tool\n")
    return folder


def clean(**more: str) -> dict[str, str]:
    """The environment of the tests without what a workspace, or the wheels, may have set."""
    names = (*PATHS[:4], "LAUNCHER_WORKSPACE", "LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE")
    return {**{k: v for k, v in os.environ.items() if k not in names}, **more}


def run(words: Sequence[object], folder: Path, env: Mapping[str, str] | None = None) -> str:
    """The standard output of a command, which must succeed."""
    done = subprocess.run(
        [str(word) for word in words],
        cwd=folder,
        env=clean() if env is None else dict(env),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=200,
    )
    assert done.returncode == 0, f"{words}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def launcher(folder: Path, *words: object, **env: str) -> str:
    return run([sys.executable, "-m", "launcher", *words], folder, clean(**env))


def sourced(script: Path, **env: str) -> dict[str, str]:
    """The environment after a script."""
    text = run(["sh", "-c", f". {shlex.quote(str(script))} && env -0"], script.parent, clean(**env))
    return dict(entry.split("=", 1) for entry in text.split("\0") if entry)


def build(workspace: Path, *options: str, **env: str) -> None:
    prefixes = [part for part in (env.pop("AMENT_PREFIX_PATH", ""), sys.prefix) if part]
    path = f"{TOOLS}:{os.environ['PATH']}"
    env = {"HOME": str(workspace), "PATH": path, "AMENT_PREFIX_PATH": ":".join(prefixes), **env}
    env["CMAKE_PREFIX_PATH"] = env["AMENT_PREFIX_PATH"]
    options = ("--cmake-args", "-GNinja", "-DBUILD_TESTING=OFF", *options)
    run([TOOLS / "colcon", "build", *options], workspace, clean(**env))


@pytest.fixture(scope="module")
def ros(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A prefix laid out as /opt/ros/jazzy: installed by ament, without any data of colcon."""
    folder = tmp_path_factory.mktemp("ros")
    source = write_cmake_package(folder, "ros_base", "ament_generate_environment()")
    prefix = folder / "opt/ros/jazzy"
    path = {"PATH": f"{TOOLS}:{os.environ['PATH']}", "AMENT_PREFIX_PATH": sys.prefix}
    env = clean(**path, CMAKE_PREFIX_PATH=sys.prefix)
    made = folder / "build"
    options = [f"-DCMAKE_INSTALL_PREFIX={prefix}", "-DBUILD_TESTING=OFF", "-GNinja"]
    run([TOOLS / "cmake", "-S", source, "-B", made, *options], folder, env)
    run([TOOLS / "cmake", "--install", made], folder, env)
    return prefix


LAYOUTS = [
    "--symlink-install",
    pytest.param("", marks=pytest.mark.thorough),
    pytest.param("--merge-install", marks=pytest.mark.thorough),
]


@pytest.fixture(scope="module", params=LAYOUTS)
def workspace(
    request: pytest.FixtureRequest, ros: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """A workspace that was built in a shell that had sourced the installation.

    Without a space in its path, which the script of colcon cannot have.
    """
    root = tmp_path_factory.mktemp("wörkspace")
    write_package(root / "src", "py_pkg", depends="<exec_depend>data_pkg</exec_depend>")
    write_cmake_package(root / "src", "data_pkg")
    options = [request.param] if request.param else []
    build(root, *options, AMENT_PREFIX_PATH=str(ros))
    return root


@pytest.mark.thorough
def test_the_environment_is_that_of_the_script(workspace: Path):
    ours = json.loads(launcher(workspace / "src/py_pkg", "env", "--json"))["env"]
    installed = {"AMENT_PREFIX_PATH": sys.prefix, **ros_variables({})}
    theirs = sourced(workspace / "install/setup.sh", **installed)
    assert {*PATHS, "ROS_BASE_DATA", "DATA_PKG_DATA"} <= {*ours}
    for name, value in ours.items():
        paths = [path for path in theirs[name].split(":") if path]  # scripts leave empty ones
        found = value.split(":")
        if name == "LD_LIBRARY_PATH":  # the wheels add theirs when Python starts
            found = [path for path in found if not path.startswith(sys.prefix)]
        assert found == paths, name


def test_a_sourced_workspace_changes_nothing(workspace: Path):
    theirs = sourced(workspace / "install/setup.sh", AMENT_PREFIX_PATH=sys.prefix)
    given = {name: theirs[name] for name in PATHS}
    ours = json.loads(launcher(workspace, "env", "--json", **given))["env"]
    assert {name: ours[name] for name in PATHS} == given


def test_nodes_and_launch_files_of_the_workspace_are_found(workspace: Path, tmp_path: Path):
    for folder, words in (
        (workspace / "src/py_pkg/launch", ()),
        (tmp_path, ("--workspace", workspace)),
    ):
        said = launcher(folder, *words, "py_pkg", "py_pkg.launch.py", "--no-log-files")
        assert said.count("node: there is p.yaml: True") == 2, said
        assert f"prefix: {workspace}/install" in said
        assert "py_pkg_talker" in launcher(folder, "plan", "py_pkg", "py_pkg.launch.py", *words)


def inspected(root: Path) -> WorkspaceFacts:
    return inspect(Workspace(str(root), str(root / "install")), clean())


def test_a_workspace_after_a_build_is_well(workspace: Path, monkeypatch: pytest.MonkeyPatch):
    for module in ("catkin_pkg", "catkin_pkg.package"):  # only the extra `build` has it
        monkeypatch.setitem(sys.modules, module, None)
    facts = inspected(workspace)
    known = {"root": str(workspace), "build": facts.build, "is_merged": facts.is_merged}
    assert facts == WorkspaceFacts(**known)
    command = [sys.executable, "-m", "launcher", "doctor", "--json"]
    # The exit code depends on what others do to the machine.
    done = subprocess.run(command, cwd=workspace, env=clean(), capture_output=True, text=True)
    findings = json.loads(done.stdout)["findings"]
    (found,) = [each for each in findings if each["check"] == "workspace"]
    assert (found["level"], found["text"]) == ("ok", f"{workspace}: everything is built")


def test_what_was_edited_since_the_build_is_stale(workspace: Path, is_linked: bool):
    files = {"data_pkg": "CMakeLists.txt", "py_pkg": "setup.py"}
    for package, file in files.items():
        with edited(workspace / "src" / package / file):
            assert inspected(workspace).changed == {package: f"{file} changed"}
    with edited(
        workspace / "src/py_pkg/py_pkg/talker.py"
    ):  # a link leads to it, or a copy was made
        assert [*inspected(workspace).changed] == ([] if is_linked else ["py_pkg"])


@contextlib.contextmanager
def edited(file: Path) -> Iterator[None]:
    before = file.stat()
    file.touch()
    yield
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))


@pytest.fixture
def is_linked(request: pytest.FixtureRequest) -> bool:
    return "--symlink-install" in request.node.name


def test_packages_that_are_new_gone_or_there_twice_are_told(workspace: Path, tmp_path: Path):
    source = workspace / "src/data_pkg"
    source.rename(tmp_path / "data_pkg")
    assert inspected(workspace).gone == ("data_pkg",)
    (tmp_path / "data_pkg").rename(source)

    for name, fact in (("py_pkg", "twice"), ("new_pkg", "changed")):
        package = write_package(workspace / "src/more", name)
        found = getattr(inspected(workspace), fact)
        shutil.rmtree(workspace / "src/more")
        folders = (str(package), str(workspace / "src/py_pkg"))
        assert found == ({"py_pkg": folders} if fact == "twice" else {"new_pkg": "not built"})


def test_links_that_lead_nowhere_are_told(workspace: Path, is_linked: bool):
    """Copies work without their sources, and without what was built of them."""
    packages = ("data_pkg", "py_pkg")
    linked = packages if is_linked else ()
    with renamed(workspace / "build"):
        assert sorted(inspected(workspace).broken) == [*linked]
    with renamed(workspace / "src"):
        facts = inspected(workspace)
    assert (sorted(facts.gone), sorted(facts.dead)) == ([*packages], [*linked])


@contextlib.contextmanager
def renamed(folder: Path) -> Iterator[None]:
    other = folder.rename(folder.with_name("other"))
    yield
    other.rename(folder)


def test_a_copy_that_leads_to_its_original_is_told(
    workspace: Path, tmp_path: Path, is_linked: bool
):
    copy = tmp_path / "copy"
    shutil.copytree(workspace, copy, symlinks=True)
    assert inspected(copy).moved_from == (str(workspace) if is_linked else None)
    command = [sys.executable, "-m", "launcher", "interface", "list"]
    done = subprocess.run(command, cwd=copy, env=clean(), capture_output=True, text=True)
    said = f"warning: {copy} was built in {workspace}, and moved or copied from there"
    assert done.stderr.startswith(said) == is_linked


def test_a_workspace_that_was_never_built_is_told(tmp_path: Path):
    write_package(tmp_path / "src", "new_pkg")
    command = [sys.executable, "-m", "launcher"]
    done = subprocess.run([*command, "env"], cwd=tmp_path, env=clean(), capture_output=True)
    assert f"note: the workspace {tmp_path} is not built" in done.stderr.decode()
    done = subprocess.run([*command, "doctor"], cwd=tmp_path, env=clean(), capture_output=True)
    assert "must be built: new_pkg (not built)" in done.stdout.decode()


def test_interfaces_that_are_not_built_are_told_again_at_the_end_of_a_failed_run(tmp_path: Path):
    src = tmp_path / "src"
    bot = write_package(src, "bot", depends="<exec_depend>bot_msgs</exec_depend>")
    write(src, interface_package("bot_msgs", {"msg/Word.msg": "string word\n"}))
    (bot / "bot/talker.py").write_text("import bot_msgs.msg\n")

    words = [sys.executable, "-m", "launcher", "bot", "bot_xml.launch.xml"]
    done = subprocess.run(words, cwd=tmp_path, env=clean(), capture_output=True, timeout=200)

    told = "warning: bot needs bot_msgs, which is not built\nhint: python -m launcher build\n"
    assert (done.returncode, done.stderr.decode().count(told)) == (1, 2), done
    assert done.stderr.decode().endswith(told)


def test_a_build_of_another_python_is_told(workspace: Path, is_linked: bool):
    lib = next(path for path in workspace.glob("install/**/lib/python3*") if path.is_dir())
    other = lib.with_name("python3.4")
    lib.rename(other)
    assert inspected(workspace).other_python == {"py_pkg": "3.4"}
    other.rename(lib)

    (program,) = workspace.glob("install/**/lib/py_pkg/py_pkg_talker")
    text = program.read_text()
    program.write_text("#!/gone/bin/python\n")
    assert inspected(workspace).no_interpreter == {"py_pkg": "/gone/bin/python"}
    program.write_text(text)


def test_a_package_of_the_environment_that_the_workspace_replaces_is_told(
    workspace: Path, tmp_path: Path
):
    marker = tmp_path / "share/ament_index/resource_index/packages/data_pkg"
    marker.parent.mkdir(parents=True)
    marker.touch()
    found = inspect(
        Workspace(str(workspace), str(workspace / "install")),
        clean(AMENT_PREFIX_PATH=f"{workspace}/install/data_pkg:{tmp_path}"),
    )
    assert found.hides == {"data_pkg": str(tmp_path)}


def test_the_variables_of_env_serve_a_shell_twice(workspace: Path, tmp_path: Path):
    script = (
        'eval "$($P env)" && env -0 > "$T/one" && eval "$($P env)" && env -0 > "$T/two" && cd / &&'
        " python -c 'import py_pkg; print(py_pkg.__file__)'"
    )
    env = clean(P=f"{TOOLS / 'launcher'}", T=str(tmp_path), PATH=f"{TOOLS}:/usr/bin:/bin")
    said = run(["sh", "-c", script], workspace, env)
    assert said.startswith(str(workspace))
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_outside_of_a_workspace_only_the_wheels_are_named(tmp_path: Path):
    installed = {"AMENT_PREFIX_PATH": sys.prefix, **ros_variables({})}
    lines = [f"export {name}={installed[name]}\n" for name in sorted(installed)]
    assert launcher(tmp_path, "env") == "".join(lines)
    assert json.loads(launcher(tmp_path, "env", "--json")) == {"version": 1, "env": installed}


def test_the_nearest_place_that_is_named_counts(tmp_path: Path):
    """--workspace, then the variable, then the working directory; an empty one is none."""
    for name in ("one", "two"):
        (tmp_path / name / "install").mkdir(parents=True)
        (tmp_path / name / "install/.colcon_install_layout").write_text("isolated\n")
        (tmp_path / name / "install/_local_setup_util_sh.py").touch()
    one, two = tmp_path / "one", tmp_path / "two"

    def chosen(*words: object, **env: str) -> str | None:
        said = json.loads(launcher(one, *words, "--json", **env))["env"]
        return said.get("COLCON_PREFIX_PATH")

    assert chosen("env") == f"{one}/install"
    assert chosen("env", LAUNCHER_WORKSPACE=str(two)) == f"{two}/install"
    assert chosen("--workspace", "../two", "env") == f"{two}/install"
    assert chosen("env", f"--workspace={two}", LAUNCHER_WORKSPACE="") == f"{two}/install"
    assert chosen("env", "--workspace=") is None
    assert chosen("env", LAUNCHER_WORKSPACE="") is None


@pytest.mark.parametrize(
    "words",
    [
        ("--workspace", "DIR", "topic", "list"),
        ("topic", "--workspace", "DIR", "list"),
        ("topic", "list", "--workspace=DIR"),
        ("ps", "--workspace", "DIR"),
        ("--workspace", "DIR", "some.launch.py"),
        ("some.launch.py", "name:=value", "--workspace", "DIR"),
        ("run", "pkg", "--workspace", "DIR"),
    ],
)
def test_every_verb_takes_the_option_anywhere(tmp_path: Path, words: tuple[str, ...]):
    """The error about the folder shows that the option was understood."""
    command = [sys.executable, "-m", "launcher", *words]
    done = subprocess.run(command, cwd=tmp_path, env=clean(), capture_output=True, text=True)
    if words[0] == "ps":  # needs no workspace
        assert "DIR" not in done.stderr
        return
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"error: workspace '{tmp_path}/DIR' does not exist"), done.stderr


def test_names_of_a_workspace_are_completed(workspace: Path, tmp_path: Path):
    for folder, words in ((workspace, ""), (tmp_path, f"--workspace {workspace} ")):
        line = f"launcher {words}run py_pkg "
        assert launcher(folder, "completion", "bash", line) == "py_pkg_talker \n"


def test_words_of_a_program_are_left_to_it(workspace: Path):
    said = launcher(workspace, "run", "py_pkg", "py_pkg_talker", "--workspace", "DIR")
    assert said.endswith("['--workspace', 'DIR']\n")


SCRIPT = """
import os  # LaunchService
with open("/proc/self/environ", "rb") as file:
    started_with = dict(each.split(b"=", 1) for each in file.read().split(b"\\0") if each)
print(started_with[b"LD_LIBRARY_PATH"].split(b":")[0].decode())
print(started_with[b"LD_LIBRARY_PATH"].decode() == os.environ["LD_LIBRARY_PATH"])
print([name for name in os.environ if name.startswith("_LAUNCHER")])
"""


def test_a_script_is_started_with_the_libraries_of_the_workspace(workspace: Path, tmp_path: Path):
    """The loader takes them from the environment that the process was executed with."""
    (tmp_path / "script.py").write_text(SCRIPT)
    for folder, words in ((workspace, ()), (tmp_path, ("--workspace", workspace))):
        first, *others = launcher(folder, *words, tmp_path / "script.py").splitlines()
        assert (workspace / "install") in Path(first).parents
        assert others == ["True", "[]"]


def test_env_quotes_what_shells_would_read(tmp_path: Path):
    root = tmp_path / "it's $HOME `ö` \\"
    texts = {
        ".colcon_install_layout": "isolated\n",
        "pkg/share/colcon-core/packages/pkg": "",
        "pkg/share/pkg/package.dsv": "set;ODD;a 'b' \"$(c)\"\nprepend-non-duplicate;PATH;bin\n",
    }
    write_install(root, texts)
    script = f'eval "$({sys.executable} -m launcher env)"; printf %s "$ODD|${{PATH%%:*}}"'
    expected = f"a 'b' \"$(c)\"|{root}/install/pkg/bin"
    assert run(["sh", "-c", script], root) == expected


def write_install(root: Path, texts: Mapping[str, str]) -> None:
    for name, text in texts.items():
        file = root / "install" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)


def test_a_hook_that_cannot_be_read_is_an_error_with_its_place(tmp_path: Path):
    texts = {
        ".colcon_install_layout": "isolated\n",
        "pkg/share/colcon-core/packages/pkg": "",
        "pkg/share/pkg/package.dsv": "set-always;X;1\n",
    }
    write_install(tmp_path, texts)
    command = [sys.executable, "-m", "launcher", "topic", "list"]
    done = subprocess.run(command, cwd=tmp_path, env=clean(), capture_output=True, text=True)
    assert done.returncode == 2
    place = f"{tmp_path}/install/pkg/share/pkg/package.dsv:1"
    assert done.stderr.startswith(f"error: {place}: 'set-always;X;1' is not an environment hook")
