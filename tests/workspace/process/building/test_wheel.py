"""`launcher wheel`: real wheels of a built workspace, installed by pip into an environment of their
own that knows nothing of the workspace.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import signal
import subprocess
import sys
import zipfile
from email import message_from_bytes
from pathlib import Path

import pytest
from elftools.elf.elffile import ELFFile

from tests.support.environments import environment_with_ros
from tests.support.repository import REPOSITORY
from tests.support.workspaces import COMPILED, EXAMPLE, launcher
from tests.workspace.process.building.small_packages import files_package, python_package
from tests.workspace.unit.building.source_tree import write

STATION = {
    "package.xml": """\
<package format="3">
  <name>station_msgs</name><version>1.2.3</version>
  <description>Stations of robots, Größe in Metern</description>
  <maintainer email="a@example.org">Jörg Ä</maintainer><license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
  <depend>fleet_interfaces</depend>
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export><build_type>ament_cmake</build_type></export>
</package>
""",
    "CMakeLists.txt": """\
cmake_minimum_required(VERSION 3.10)
project(station_msgs)
find_package(ament_cmake REQUIRED)
find_package(fleet_interfaces REQUIRED)
find_package(rosidl_default_generators REQUIRED)
rosidl_generate_interfaces(${PROJECT_NAME} "msg/Station.msg" DEPENDENCIES fleet_interfaces)
ament_package()
""",
    "msg/Station.msg": "fleet_interfaces/RobotStatus[] robots\nwstring name\n",
    "LICENSE": "As you like.\n",
}
# Publishes to itself until a message has arrived; the words are a module, a type, and fields.
ROUND_TRIP = """\
import importlib, json, sys, time
import rclpy
package, name, fields = sys.argv[1:]
kind = getattr(importlib.import_module(package + ".msg"), name)
message = kind(**json.loads(fields))
rclpy.init()
node = rclpy.create_node("round_trip")
arrived = []
node.create_subscription(kind, "round_trip", arrived.append, 10)
publisher = node.create_publisher(kind, "round_trip", 10)
deadline = time.monotonic() + 60
while not arrived and time.monotonic() < deadline:
    publisher.publish(message)
    rclpy.spin_once(node, timeout_sec=0.1)
assert arrived and arrived[0] == message, arrived
print(arrived[0])
"""


@pytest.mark.thorough
def test_wheels_need_nothing_but_pip(wheels, environment, tmp_path):
    before = environment.files()
    environment.pip("install", "--no-index", "--find-links", str(wheels), "fleet_nodes")
    assert "No broken requirements" in environment.pip("check")

    fields = json.dumps({"task": "pick", "robot_id": "röbot", "priority": 1})
    words = ("-c", ROUND_TRIP, "fleet_interfaces", "TaskAssignment", fields)
    assert "robot_id='röbot'" in environment.run(*words)

    checkout = {"PYTHONPATH": str(REPOSITORY)}
    shown = environment.run(
        *("-m", "launcher", "interface", "show", "fleet_interfaces/action/ExecuteTask"),
        cwd=tmp_path,
        **checkout,
    )
    assert "TaskAssignment assignment" in shown
    plan = environment.run(
        *("-m", "launcher", "plan", "fleet_nodes", "fleet.launch.py"), cwd=tmp_path, **checkout
    )
    assert "dispatcher" in plan
    assert (environment.prefix / "bin/dispatcher").is_file()

    environment.pip("uninstall", "--yes", "fleet_nodes", "fleet_interfaces")
    assert environment.files() == before


@pytest.mark.thorough
def test_auditwheel_agrees(wheels):
    wheel = only(wheels, "fleet_interfaces")
    report = audit(wheel)
    platform = wheel.stem.split("-")[-1]
    assert platform.startswith("manylinux_2_")
    # auditwheel knows nothing of other wheels: what it calls external must be theirs.
    assert report["sym_tag"] == platform
    ours = {path.name for path in (Path(sys.prefix) / "lib").iterdir()}
    foreign = report["policy_upgrades"].get(platform, {}).get("libs_to_eliminate", [])
    assert {name for name in foreign if "fleet_interfaces" not in name} <= ours


@pytest.mark.thorough
def test_what_a_wheel_of_messages_contains(workspace, wheels):
    wheel = only(wheels, "fleet_interfaces")
    python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    assert wheel.name.startswith(f"fleet_interfaces-0.1.0-{python}-{python}-manylinux")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        metadata = message_from_bytes(archive.read("fleet_interfaces-0.1.0.dist-info/METADATA"))
        everything = b"".join(map(archive.read, names))
        libraries = [archive.read(name) for name in names if name.endswith(".so")]
    data = "fleet_interfaces-0.1.0.data/data"
    assert f"{data}/lib/libfleet_interfaces__rosidl_typesupport_fastrtps_c.so" in names
    assert f"{data}/share/ament_index/resource_index/packages/fleet_interfaces" in names
    assert f"{data}/share/fleet_interfaces/cmake/fleet_interfacesConfig.cmake" in names
    assert f"{data}/share/fleet_interfaces/action/ExecuteTask.action" in names
    assert "fleet_interfaces/msg/_robot_status.py" in names
    assert not [name for name in names if "egg-info" in name or "local_setup" in name]
    required = metadata.get_all("Requires-Dist")
    assert [one for one in required if one.startswith("ros-std-msgs~=")]
    assert [one for one in required if one.startswith("ros-rosidl-default-runtime~=")]
    assert metadata["Requires-Python"] == f"=={sys.version_info[0]}.{sys.version_info[1]}.*"
    assert metadata["License"] == "MIT"
    assert os.fsencode(sys.prefix) not in everything
    assert os.fsencode(workspace) not in everything
    for library in libraries:
        elf = ELFFile(io.BytesIO(library))
        assert not [
            one.name for one in elf.iter_sections() if one.name in (".symtab", ".debug_info")
        ]


@pytest.mark.thorough
def test_a_python_package_fits_every_machine(wheels):
    wheel = only(wheels, "fleet_nodes")
    assert wheel.name == "fleet_nodes-0.1.0-py3-none-any.whl"
    with zipfile.ZipFile(wheel) as archive:
        metadata = message_from_bytes(archive.read("fleet_nodes-0.1.0.dist-info/METADATA"))
        entry_points = archive.read("fleet_nodes-0.1.0.dist-info/entry_points.txt").decode()
        assert "fleet_nodes/robot.py" in archive.namelist()
    assert "fleet_interfaces>=0.1.0" in metadata.get_all("Requires-Dist")
    assert "robot = fleet_nodes.robot:main" in entry_points


@pytest.mark.thorough
def test_the_same_bytes_again(workspace, wheels, tmp_path):
    old = {path.name: path.read_bytes() for path in wheels.iterdir()}
    answer = launcher(workspace, "wheel", "--all", "--output", str(tmp_path / "neu ä"))
    assert answer.code == 0, answer.err
    assert {path.name: path.read_bytes() for path in (tmp_path / "neu ä").iterdir()} == old
    assert "unchanged" not in answer.out
    again = launcher(workspace, "wheel", "--all", "--output", str(tmp_path / "neu ä"))
    assert again.out.count("unchanged") == len(old)


@pytest.mark.thorough
def test_libraries_are_found_in_a_plain_shell(workspace, environment):
    """PYTHONPATH alone, without LD_LIBRARY_PATH."""
    words = ("-c", ROUND_TRIP, "fleet_interfaces", "TaskAssignment", '{"task": "pick"}')
    environment.run(*words, PYTHONPATH=modules_of(workspace, "fleet_interfaces"))


# ---- mistakes


@pytest.mark.thorough
def test_what_cannot_be_packed(workspace, tmp_path):
    unknown = launcher(workspace, "wheel", "fleet_interface")
    assert (unknown.code, unknown.err) == (
        2,
        "error: no package 'fleet_interface' in src\nhint: did you mean 'fleet_interfaces'?\n",
    )
    assert launcher(workspace, "wheel").code == 2
    assert launcher(workspace, "wheel", "--all", "fleet_nodes").code == 2
    (tmp_path / "file").touch()
    taken = launcher(workspace, "wheel", "fleet_nodes", "--output", str(tmp_path / "file"))
    assert taken.code == 2 and "is not a folder" in taken.err
    nowhere = launcher(workspace, "wheel", "fleet_nodes", "--output", "/proc/none/dist")
    assert nowhere.code == 1 and "cannot be made: No such file or directory" in nowhere.err
    late = launcher(workspace, "wheel", "fleet_nodes", SOURCE_DATE_EPOCH="today")
    assert late.code == 2 and "SOURCE_DATE_EPOCH" in late.err


def test_a_package_that_is_not_built(tmp_path):
    shutil.copytree(EXAMPLE / "src", tmp_path / "src", ignore=COMPILED)
    answer = launcher(tmp_path, "wheel", "fleet_nodes")
    assert answer.code == 1
    assert answer.err.startswith("error: fleet_interfaces is not built\nhint: ")
    assert "build src/fleet_interfaces" in answer.err
    assert not (tmp_path / "dist").exists()


@pytest.mark.thorough
def test_sources_that_changed_after_the_build(workspace, tmp_path):
    """`install/` has links to the sources: the wheel would not fit its libraries."""
    copy = tmp_path / "copy"
    shutil.copytree(workspace, copy, symlinks=True, ignore=COMPILED)
    message = copy / "src/fleet_interfaces/msg/RobotStatus.msg"
    message.write_text(message.read_text() + "bool is_late\n")
    answer = launcher(copy, "wheel", "fleet_interfaces")
    assert answer.code == 1
    assert "fleet_interfaces has changed since it was built" in answer.err
    assert "msg/RobotStatus.msg changed" in answer.err


@pytest.mark.thorough
def test_other_packages_are_packed_although_some_cannot_be(tmp_path):
    src = tmp_path / "src"
    for name in ("a", "b", "c"):
        python_package(src, name)
    for name in ("a", "b"):
        (src / name / "setup.py").write_text(f"raise SystemExit('error: not {name}')\n")
    files_package(src, "files")
    answer = launcher(tmp_path, "wheel", "--all")
    assert answer.code == 1
    assert answer.out.startswith("dist/c-0.1.0-py3-none-any.whl (")
    assert "install with" not in answer.out
    lines = answer.err.splitlines()
    assert [line for line in lines if line.startswith("error: ")] == [
        "error: src/a/setup.py: setuptools cannot make a wheel of a: error: not a",
        "error: src/b/setup.py: setuptools cannot make a wheel of b: error: not b",
        "error: files is not built",
    ]


def test_wheels_are_installed_by_their_files(tmp_path):
    """By its name, pip would take a newer package of a stranger."""
    python_package(tmp_path / "src", "a")
    python_package(tmp_path / "src", "b", "a")
    answer = launcher(tmp_path, "wheel", "b", "--output", "my dist")
    assert answer.code == 0
    files = (f"'my dist/{name}-0.1.0-py3-none-any.whl'" for name in "ab")
    assert answer.out.splitlines()[-1] == f"install with: pip install {' '.join(files)}"


def test_ctrl_c(tmp_path):
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    folder = python_package(tmp_path / "src", "p")
    (folder / "setup.py").write_text(f"open({str(fifo)!r}).read()\n")
    process = subprocess.Popen(
        [sys.executable, "-m", "launcher", "wheel", "p"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    with open(fifo, "w"):  # once setup.py has opened it
        os.killpg(process.pid, signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert (process.returncode, said) == (130, "\ninterrupted: finished wheels are kept\n")
    assert list((tmp_path / "dist").iterdir()) == []


# ---- builds of their own


@pytest.mark.thorough
@pytest.mark.parametrize("compiler", ["system", "zig"])
def test_another_folder_has_the_same_bytes_and_can_be_moved(tmp_path, environment, compiler):
    made = []
    for name, words in (("a", ()), ("größer und/weiter", ("--copy",))):
        root = tmp_path / name
        shutil.copytree(EXAMPLE / "src/fleet_interfaces", root / "src/fleet_interfaces")
        write(root / "src/station_msgs", STATION)
        assert launcher(root, "build", "--compiler", compiler, *words).code == 0
        answer = launcher(root, "wheel", "station_msgs")
        assert (answer.code, answer.err) == (0, "")
        made.append({path.name: path.read_bytes() for path in (root / "dist").iterdir()})
        assert len(made[-1]) == 2
    assert made[0] == made[1]
    if compiler == "zig":
        platforms = [name.removesuffix(".whl").split("-")[-1].split("_") for name in made[0]]
        assert all(int(one[2]) <= 28 for one in platforms), platforms

    # Nothing is a link in the second: its packages find each other anywhere, in a plain shell.
    moved = root.rename(tmp_path / "moved")
    folders = [modules_of(moved, name) for name in ("fleet_interfaces", "station_msgs")]
    words = ("-c", ROUND_TRIP, "station_msgs", "Station", '{"robots": []}')
    environment.run(*words, PYTHONPATH=":".join(folders))


@pytest.mark.thorough
def test_another_workspace_builds_upon_a_wheel(workspace, wheels, environment, tmp_path):
    environment.pip("install", "--no-index", "--find-links", str(wheels), "fleet_interfaces")
    root = tmp_path / "upper"
    write(root / "src/station_msgs", STATION)
    tools = {
        "PYTHONPATH": str(REPOSITORY),
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
    }
    environment.run("-m", "launcher", "build", cwd=root, **tools)
    environment.run("-m", "launcher", "wheel", "station_msgs", cwd=root, **tools)
    wheel = only(root / "dist", "station_msgs")
    with zipfile.ZipFile(wheel) as archive:
        info = "station_msgs-1.2.3.dist-info"
        metadata = message_from_bytes(archive.read(f"{info}/METADATA"))
        assert archive.read(f"{info}/licenses/LICENSE") == b"As you like.\n"
    assert "fleet_interfaces==0.1.0" in metadata.get_all("Requires-Dist")

    fields = '{"name": "größer \U0001f916"}'
    words = ("-c", ROUND_TRIP, "station_msgs", "Station", fields)
    environment.run(*words, PYTHONPATH=modules_of(root, "station_msgs"))  # in a plain shell
    environment.pip("install", "--no-index", str(wheel))
    environment.run(*words)


# ---- support


@pytest.fixture
def workspace(fleet_workspace):
    return fleet_workspace.root


@pytest.fixture(scope="module")
def wheels(fleet_workspace, tmp_path_factory):
    """The folder with all wheels of the workspace."""
    folder = tmp_path_factory.mktemp("wheels") / "dist"
    answer = launcher(fleet_workspace.root, "wheel", "--all", "--output", str(folder))
    assert answer.code == 0 and "warning" not in answer.err, answer.err
    return folder


@pytest.fixture
def environment(tmp_path):
    return environment_with_ros(tmp_path / "env")


def audit(wheel):
    """What auditwheel says of a wheel."""
    command = [sys.executable, "-m", "auditwheel", "show", "--json", str(wheel)]
    libraries = str(Path(sys.prefix) / "lib")
    done = subprocess.run(
        [*command, "--ldpaths", libraries], capture_output=True, text=True, check=True, timeout=60
    )
    return json.loads(done.stdout)


def only(folder, package):
    (found,) = folder.glob(f"{package}-*.whl")
    return found


def modules_of(root, package):
    (found,) = (root / "install" / package / "lib").glob("python*/site-packages")
    return str(found)
