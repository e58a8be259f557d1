"""`pkg create`: which names are accepted, where packages go, and that nothing is overwritten."""

from __future__ import annotations

import ast
import errno
import os
import runpy
import xml.etree.ElementTree as ElementTree

import pytest

from launcher.base.errors import UsageError
from launcher.workspace.building.create import target_folder
from launcher.workspace.building.create.create import UNKNOWN_EMAIL, maintainer
from launcher.workspace.building.create.templates import class_name
from tests.support.verbs import in_process


@pytest.fixture(autouse=True)
def workspace(tmp_path, monkeypatch):
    """The root of a workspace, as working directory, and no settings of git."""
    root = tmp_path / "ws ä"
    (root / "src").mkdir(parents=True)
    monkeypatch.chdir(root)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("GIT_CONFIG_NOSYSTEM", "1")
    return root


def create(*words):
    return in_process("pkg", "create", *words)


def files(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_the_workspace_that_the_option_names(workspace, tmp_path, monkeypatch):
    monkeypatch.setenv("LAUNCHER_WORKSPACE", "")  # which the option changes
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my ws").symlink_to(workspace)

    answer = create("demo", "--workspace", "my ws")

    assert answer.code == 0
    assert (workspace / "src/demo/package.xml").is_file()
    program = "  python -m launcher --workspace 'my ws'"
    assert {f"{program} build", f"{program} launch demo demo.launch.py"} <= {
        *answer.out.splitlines()
    }
    monkeypatch.chdir(workspace / "src")
    assert "--workspace" not in create("other", "--workspace", str(workspace)).out


def test_a_workspace_that_does_not_exist(tmp_path, monkeypatch):
    monkeypatch.setenv("LAUNCHER_WORKSPACE", str(tmp_path / "no"))
    answer = create("demo")
    assert answer.code == 2
    assert f"workspace '{tmp_path}/no' is not a folder" in answer.err


# ---- what is made


def test_a_package_of_nodes(workspace):
    answer = create("demo", "--node", "alpha", "--node", "beta")

    assert (answer.code, answer.err) == (0, "")
    assert files(workspace / "src") == [
        "demo/demo/__init__.py",
        "demo/demo/alpha.py",
        "demo/demo/beta.py",
        "demo/launch/demo.launch.py",
        "demo/package.xml",
        "demo/resource/demo",
        "demo/setup.cfg",
        "demo/setup.py",
        "demo/test/test_demo.py",
        "demo/test/test_demo_launch.py",
    ]
    assert answer.out.splitlines() == [
        "created src/demo/ with alpha.py, beta.py, demo.launch.py, test_demo.py, "
        "test_demo_launch.py",
        "to fill in, in package.xml and setup.py: description, license, maintainer",
        "next:",
        "  python -m launcher build",
        "  python -m launcher test demo",
        "  python -m launcher launch demo demo.launch.py",
    ]


def test_everything_beside_the_launch_file_is_installed(workspace, monkeypatch):
    create("demo")
    folder = workspace / "src/demo"
    for name in ("demo.expect.yaml", "demo.supervise.yaml", "other.launch.xml", "shared.py"):
        (folder / "launch" / name).touch()
    (folder / "launch/__pycache__").mkdir()  # a folder would make setuptools give up
    given = {}
    monkeypatch.setattr("setuptools.setup", lambda **values: given.update(values))
    monkeypatch.chdir(folder)
    runpy.run_path("setup.py")

    assert dict(given["data_files"])["share/demo/launch"] == [
        "launch/demo.expect.yaml",
        "launch/demo.launch.py",
        "launch/demo.supervise.yaml",
        "launch/other.launch.xml",
        "launch/shared.py",
    ]


@pytest.mark.parametrize("name", ["top", "graph", "help"])
def test_a_package_that_is_called_like_a_verb_is_launched_by_launch(workspace, name):
    answer = create(name)

    assert (answer.code, answer.err) == (0, "")
    assert answer.out.splitlines()[-1] == f"  python -m launcher launch {name} {name}.launch.py"


def test_without_a_name_the_node_is_called_like_the_package(workspace):
    assert create("demo").code == 0
    assert (workspace / "src/demo/demo/demo_node.py").is_file()


def test_a_package_of_interfaces(workspace):
    answer = create("demo_msgs", "--interfaces", "--dependencies", "std_msgs", "std_msgs")

    assert (answer.code, answer.err) == (0, "")
    assert files(workspace / "src") == [
        "demo_msgs/CMakeLists.txt",
        "demo_msgs/action/CountTo.action",
        "demo_msgs/msg/Count.msg",
        "demo_msgs/package.xml",
        "demo_msgs/srv/ResetCount.srv",
        "demo_msgs/test/test_demo_msgs.py",
    ]
    assert "to fill in, in package.xml: description" in answer.out  # it has no setup.py
    lists = (workspace / "src/demo_msgs/CMakeLists.txt").read_text(encoding="utf-8")
    assert lists.count("find_package(std_msgs REQUIRED)") == 1
    assert "DEPENDENCIES builtin_interfaces std_msgs\n" in lists


def test_a_dependency_may_be_an_interface_package_of_the_workspace(workspace):
    create("robot", "--node", "alpha", "--interfaces")
    (workspace / "src/group").mkdir()

    for folder in ("src/group", f"{workspace}/src"):
        words = ("--interfaces", "--dependencies", "robot_interfaces", "--destination-directory")
        answer = create(f"msgs_{len(folder)}", *words, folder)
        assert (answer.code, answer.err) == (0, "")

    answer = create("more_msgs", "--interfaces", "--dependencies", "robot")
    assert answer.code == 2
    assert answer.err == "error: --dependencies: 'robot' is not a package of interfaces\n"


def test_a_dependency_may_be_an_interface_package_that_is_only_built(workspace):
    index = workspace / "install/built_msgs/share/ament_index/resource_index"
    listed = workspace / "install/built_msgs/share/colcon-core/packages"
    for folder in (index / "packages", index / "rosidl_interfaces", listed):
        folder.mkdir(parents=True)
        (folder / "built_msgs").touch()
    (workspace / "install/.colcon_install_layout").write_text("isolated\n")
    hooks = workspace / "install/built_msgs/share/built_msgs"
    hooks.mkdir()
    (hooks / "package.dsv").write_text("prepend-non-duplicate;AMENT_PREFIX_PATH;\n")

    answer = create("more_msgs", "--interfaces", "--dependencies", "built_msgs")

    assert (answer.code, answer.err) == (0, "")


def test_both_are_two_packages_of_which_one_uses_the_other(workspace):
    assert create("demo", "--node", "alpha", "--interfaces").code == 0

    assert sorted(path.name for path in (workspace / "src").iterdir()) == [
        "demo",
        "demo_interfaces",
    ]
    manifest = (workspace / "src/demo/package.xml").read_text(encoding="utf-8")
    assert "<depend>demo_interfaces</depend>" in manifest
    node = (workspace / "src/demo/demo/alpha.py").read_text(encoding="utf-8")
    assert "from demo_interfaces.msg import Count" in node


AWKWARD = "Ünïcode & <tags> \"quoted\" 'single' \\back $dollar @@name ]]> {braces}"


@pytest.mark.parametrize("words", [["--node", "alpha"], ["--interfaces"]])
def test_any_line_of_text_is_written_as_it_is(workspace, words):
    answer = create(
        "demo",
        *words,
        *("--description", AWKWARD),
        *("--license", AWKWARD),
        *("--maintainer-name", AWKWARD),
        *("--maintainer-email", "a.b-c+d@example.org"),
    )

    assert answer.code == 0
    root = ElementTree.parse(workspace / "src/demo/package.xml").getroot()
    texts = [root.findtext(tag) for tag in ("description", "license", "maintainer")]
    assert texts == [AWKWARD] * 3
    assert root.find("maintainer").get("email") == "a.b-c+d@example.org"
    for path in (workspace / "src").rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        if path.name == "setup.py":
            values = {
                word.arg: word.value for word in ast.walk(tree) if isinstance(word, ast.keyword)
            }
            assert ast.literal_eval(values["description"]) == AWKWARD


def test_the_command_of_the_ros_tutorials_is_understood(workspace):
    words = ["--build-type", "ament_python", "--license", "Apache-2.0"]
    assert create(*words, "--node-name", "my_node", "my_package").code == 0
    assert (workspace / "src/my_package/my_package/my_node.py").is_file()


@pytest.mark.parametrize(
    ("node", "expected"),
    [
        ("arm", "ArmNode"),
        ("robot_arm_2", "RobotArm2Node"),
        ("my_node", "MyNode"),
        ("node", "NodeNode"),
    ],
)
def test_no_class_is_called_like_that_of_rclpy(node, expected):
    assert class_name(node) == expected


# ---- where it goes


def test_below_the_root_the_package_goes_into_the_folder_itself(workspace, monkeypatch):
    (workspace / "src/group").mkdir()
    monkeypatch.chdir(workspace / "src/group")

    assert "created demo/" in create("demo").out
    assert (workspace / "src/group/demo/package.xml").is_file()


def test_outside_of_a_workspace_a_hint_says_how_to_make_one(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")

    answer = create("demo")

    assert (tmp_path / "elsewhere/demo/package.xml").is_file()
    assert "hint: this folder is not in a workspace" in answer.out


def test_the_destination_is_made(workspace):
    answer = create("demo", "--destination-directory", "../other ws/src")

    assert (workspace / "../other ws/src/demo/package.xml").is_file()
    assert f"  cd '{workspace.parent}/other ws/src'" in answer.out.splitlines()


def test_a_package_within_a_package_is_refused(workspace, monkeypatch):
    create("outer")
    monkeypatch.chdir(workspace / "src/outer/launch")

    answer = create("inner")

    assert answer.code == 2
    assert "is within the package" in answer.err
    assert not (workspace / "src/outer/launch/inner").exists()


@pytest.mark.parametrize("kind", ["folder", "file", "broken link"])
def test_nothing_is_overwritten(workspace, kind):
    path = workspace / "src/demo_interfaces"
    {"folder": path.mkdir, "file": path.touch, "broken link": lambda: path.symlink_to("nowhere")}[
        kind
    ]()

    answer = create("demo", "--node", "alpha", "--interfaces")

    assert answer.code == 2
    assert answer.err.startswith("error: src/demo_interfaces exists already\n")
    assert [one.name for one in (workspace / "src").iterdir()] == ["demo_interfaces"]


# ---- names


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("MyRobot", "did you mean 'my_robot'?"),
        ("my-robot", "did you mean 'my_robot'?"),
        ("2cool", "did you mean 'cool'?"),
        ("a__b", "did you mean 'a_b'?"),
        ("a_", "is not a valid name of a package"),
        ("x", "is not a valid name of a package"),
        ("", "is not a valid name of a package"),
        ("Café", "did you mean 'cafe'?"),
        ("../up", "is not a valid name of a package"),
        ("a\nb", "is not a valid name of a package"),
        ("class", "'class' is a keyword of Python"),
        ("json", "'json' is a module of Python"),
        ("test", "'test' is a module of Python"),
        ("install", "'install' is a folder that colcon makes"),
        ("yaml", "'yaml' is a module of this environment"),
        ("launch", "'launch' is a module of this environment"),
        ("std_msgs", "there is a package 'std_msgs' already"),
        ("group_gp1", "there is a package 'group_gp1' already"),
    ],
)
def test_names_that_packages_cannot_have(workspace, name, sentence):
    answer = create(name)

    assert answer.code == 2
    assert sentence in answer.err
    assert files(workspace) == []


@pytest.mark.parametrize("name", ["My-Robot", "Class", "Json", "Std_Msgs", "Install", "größe"])
def test_a_name_that_would_be_refused_is_not_suggested(workspace, name):
    (workspace / "src/my_robot").mkdir()

    answer = create(name)

    assert answer.code == 2
    assert f"'{name}' is not a valid name of a package" in answer.err
    assert "did you mean" not in answer.err


@pytest.mark.parametrize("other", ["a_b", "ab_node"])
def test_a_node_that_would_be_refused_is_not_suggested(other):
    meant = {"a_b": "A-b", "ab_node": "Ab"}[other]
    assert "did you mean" not in create("demo", "--node", other, "--node", meant).err


def test_the_name_of_another_package_of_the_workspace_is_refused(workspace):
    create("demo")
    (workspace / "src/demo").rename(workspace / "src/folder_of_another_name")

    answer = create("demo")

    assert answer.code == 2
    assert "there is a package 'demo' already" in answer.err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["demo", "--node", "Talker"], "did you mean 'talker'?"),
        (["demo", "--node", "import"], "'import' is a keyword of Python"),
        (["demo", "--node", "a1", "--node", "a1"], "the node 'a1' is given twice"),
        (["demo", "--node", "b1", "--node", "b_1"], "would both be the class B1Node"),
        (["demo", "--node", "a1", "b1"], "repeat the option for each node"),
        (["demo", "--maintainer-email", "nobody"], "'nobody' is not an e-mail address"),
        (["demo", "--description", "two\nlines"], "is not a line of text"),
        (["demo", "--license", " "], "is not a line of text"),
        (["demo", "--dependencies", "a b"], "is not the name of a package or of a rosdep key"),
        (["demo", "--dependencies", "demo"], "is a package that is to be created"),
        (["demo_msgs", "--node", "a1", "--interfaces"], "pkg create demo --node NODE"),
        (["demo", "--build-type", "ament_cmake"], "nodes in C++ need rclcpp"),
        (["demo", "--build-type", "ament_python", "--interfaces"], "generated by CMake"),
        (["demo", "--interfaces", "--dependencies", "rclpy"], "not a package of interfaces"),
        ([], "NAME is missing"),
    ],
)
def test_mistakes_of_the_command_line(workspace, words, sentence):
    answer = create(*words)

    assert answer.code == 2
    assert sentence in answer.err
    assert files(workspace) == []


def test_an_unknown_dependency_is_a_warning_with_a_near_name(workspace):
    answer = create("demo", "--dependencies", "std_msg", "python3-numpy")

    assert answer.code == 0
    assert answer.err == "warning: no package 'std_msg' is known; did you mean 'std_msgs'?\n"
    assert "python3-numpy" not in answer.out


# ---- the disk


def test_after_a_full_disk_nothing_is_left(workspace, monkeypatch):
    """Stands for a disk that is full after the first file of the second package."""
    written = []
    before = os.mkdir

    def mkdir(path, *more):
        written.append(path)
        if ".demo." in str(path):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        before(path, *more)

    monkeypatch.setattr(os, "mkdir", mkdir)
    answer = create("demo", "--node", "alpha", "--interfaces", "--destination-directory", "a/b")

    assert answer.code == 1
    assert answer.err.startswith("error: nothing was created: ")
    assert "No space left on device" in answer.err
    assert any(".demo_interfaces." in str(path) for path in written)
    assert not (workspace / "a").exists()


def test_packages_are_readable_as_the_umask_says(workspace):
    create("demo")
    assert (workspace / "src/demo").stat().st_mode & 0o777 == 0o777 & ~_umask()


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_a_destination_below_a_file_is_refused(workspace):
    (workspace / "file").touch()
    with pytest.raises(UsageError, match="file is not a folder"):
        target_folder.destination("file/src")


# ---- the maintainer


def test_the_maintainer_is_that_of_git(tmp_path, workspace):
    (tmp_path / ".gitconfig").write_text(
        "[user]\n  name = Jörg Example\n  email = joerg@example.org\n", encoding="utf-8"
    )
    assert maintainer(None, None, str(workspace)) == ("Jörg Example", "joerg@example.org")
    assert maintainer("X", "x@example.org", str(workspace)) == ("X", "x@example.org")


def test_without_git_the_user_is_the_maintainer(workspace, monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setenv("LOGNAME", "somebody")
    assert maintainer(None, None, str(workspace)) == ("somebody", UNKNOWN_EMAIL)


def test_an_address_that_package_xml_cannot_have_is_left_out(tmp_path, workspace):
    (tmp_path / ".gitconfig").write_text("[user]\n  email = root@localhost\n", encoding="utf-8")
    assert maintainer("X", None, str(workspace))[1] == UNKNOWN_EMAIL
