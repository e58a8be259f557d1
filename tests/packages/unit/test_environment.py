"""What a workspace sets, from the data that colcon and ament install."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest

from launcher.packages.environment import environment, of_build, packages, read
from launcher.packages.hooks import WorkspaceError
from launcher.packages.workspace import MARKER, Workspace


class Prefix:
    """An `install` that packages are put into as colcon does."""

    def __init__(self, root: Path, layout: str = "isolated") -> None:
        self.path = root / "install"
        self.path.mkdir(parents=True)
        (self.path / MARKER).write_text(f"{layout}\n")
        (self.path / "_local_setup_util_sh.py").touch()
        self._layout = layout
        self.workspace = Workspace(str(root), str(self.path))

    def of(self, package: str) -> Path:
        return self.path / package if self._layout == "isolated" else self.path

    def add(self, package: str, needs: Iterable[str] = (), **hooks: str) -> Path:
        """Install a package with these `.dsv` files, by their name."""
        prefix = self.of(package)
        index = prefix / "share/colcon-core/packages"
        index.mkdir(parents=True, exist_ok=True)
        (index / package).write_text(":".join(needs))
        hook = prefix / "share" / package / "hook"
        hook.mkdir(parents=True)
        for name, text in hooks.items():
            (hook / f"{name}.dsv").write_text(text)
        lines = [
            f"source;share/{package}/hook/{name}.{end}" for name in hooks for end in ("dsv", "sh")
        ]
        (hook.parent / "package.dsv").write_text("\n".join(lines))
        return prefix

    def chain(self, *prefixes: Path) -> None:
        own = 'COLCON_CURRENT_PREFIX="$_colcon_prefix_chain_sh_COLCON_CURRENT_PREFIX"'
        lines = [*(f'COLCON_CURRENT_PREFIX="{path}"' for path in prefixes), own]
        (self.path / "setup.sh").write_text("\n".join(lines))


AMENT = "prepend-non-duplicate;AMENT_PREFIX_PATH;"
LIBRARY = "prepend-non-duplicate;LD_LIBRARY_PATH;lib"
PYTHON = "prepend-non-duplicate;PYTHONPATH;lib/python3.11/site-packages"


@pytest.mark.parametrize("layout", ["isolated", "merged"])
def test_dependencies_come_behind_what_needs_them(tmp_path: Path, layout: str):
    prefix = Prefix(tmp_path, layout)
    prefix.add("a_node", ["b_msgs", "std_msgs"], path=AMENT, python=PYTHON)
    prefix.add("b_msgs", (), path=AMENT, library=LIBRARY)

    assert [*packages(str(prefix.path))] == ["b_msgs", "a_node"]
    env = environment(prefix.workspace, {"AMENT_PREFIX_PATH": "/wheels"})

    own = dict.fromkeys([str(prefix.of("a_node")), str(prefix.of("b_msgs"))])
    assert env["AMENT_PREFIX_PATH"] == ":".join([*own, "/wheels"])
    assert env["LD_LIBRARY_PATH"] == f"{prefix.of('b_msgs')}/lib"
    assert env["PYTHONPATH"] == f"{prefix.of('a_node')}/lib/python3.11/site-packages"
    assert env["COLCON_PREFIX_PATH"] == str(prefix.path)


@pytest.mark.parametrize("named", ["", "base", "upper", "other"])
def test_a_build_is_on_what_the_last_one_was_on_unless_others_are_named(tmp_path: Path, named: str):
    base, upper, own = (Prefix(tmp_path / name) for name in ("base", "upper", "own"))
    for prefix in (base, upper, own):
        prefix.add("pkg", path=AMENT)
    own.chain(base.path, upper.path)

    given = {"AMENT_PREFIX_PATH": f"{tmp_path}/{named}/install/pkg" if named else ""}
    env = of_build(own.workspace, given)

    remembered = f"{upper.of('pkg')}:{base.of('pkg')}"
    is_other = named == "other"
    assert env["AMENT_PREFIX_PATH"] == (given["AMENT_PREFIX_PATH"] if is_other else remembered)


def test_a_cycle_of_dependencies_leaves_no_package_out(tmp_path: Path):
    prefix = Prefix(tmp_path)
    for name, need in (("a", "b"), ("b", "a"), ("c", "a")):
        prefix.add(name, [need], path=AMENT)
    assert {*packages(str(prefix.path))} == {"a", "b", "c"}


def test_every_kind_of_hook_is_read(tmp_path: Path):
    prefix = Prefix(tmp_path)
    below = prefix.of("pkg")
    (below / "share/pkg/data").mkdir(parents=True)
    prefix.add(
        "pkg",
        all="\n".join(
            [
                "# a comment",
                "",
                "append-non-duplicate;LISTED;last;/abs",
                "prepend-non-duplicate-if-exists;PATH;bin",
                "prepend-non-duplicate-if-exists;PATH;share",
                "set;DATA;share/pkg/data",
                "set;TEXT;a;b",
                "set-if-unset;MINE;theirs",
                "set-if-unset;NEW;value",
            ]
        ),
    )
    env = environment(prefix.workspace, {"LISTED": "first", "PATH": "/bin", "MINE": "mine"})
    assert env["LISTED"] == f"first:{below}/last:/abs"
    assert env["PATH"] == f"{below}/share:/bin"
    assert (env["DATA"], env["TEXT"]) == (f"{below}/share/pkg/data", "a;b")
    assert (env["MINE"], env["NEW"]) == ("mine", "value")


def test_a_hook_of_the_build_folder_is_read(tmp_path: Path):
    """--symlink-install of a Python package."""
    prefix = Prefix(tmp_path)
    below = prefix.add("pkg")
    develop = tmp_path / "build/pkg/share/pkg/hook/pythonpath_develop"
    develop.parent.mkdir(parents=True)
    develop.with_suffix(".dsv").write_text(f"prepend-non-duplicate;PYTHONPATH;{tmp_path}/build/pkg")
    line = "source;../../build/pkg/share/pkg/hook/pythonpath_develop.dsv"
    (below / "share/pkg/package.dsv").write_text(line)
    assert environment(prefix.workspace, {})["PYTHONPATH"] == f"{tmp_path}/build/pkg"


def test_a_script_without_data_is_reported_and_not_run(tmp_path: Path):
    prefix = Prefix(tmp_path)
    below = prefix.add("pkg", path=AMENT)
    script = below / "share/pkg/hook/own.sh"
    script.write_text("export OWN=1\n")
    for suffix in (".sh", ".bash"):
        with open(below / "share/pkg/package.dsv", "a") as file:
            file.write(f"\nsource;share/pkg/hook/own{suffix}")
    assert read(prefix.workspace).scripts == [str(script)]
    assert "OWN" not in environment(prefix.workspace, {})


def test_underlays_come_behind_the_workspace(tmp_path: Path):
    low, high = Prefix(tmp_path / "low"), Prefix(tmp_path / "high")
    low.add("pkg", path=AMENT)
    high.add("pkg", path=AMENT)
    ros = installation(tmp_path / "opt/ros/jazzy")
    high.chain(ros, tmp_path / "gone", low.path)

    env = environment(high.workspace, {"AMENT_PREFIX_PATH": "/wheels"})

    expected = f"{high.path}/pkg:{low.path}/pkg:{ros}:/wheels"
    assert env["AMENT_PREFIX_PATH"] == expected
    assert env["COLCON_PREFIX_PATH"] == f"{high.path}:{low.path}"
    assert env["ROS_DISTRO"] == "jazzy"


def installation(prefix: Path) -> Path:
    """An installation of ROS 2: no data of colcon, but that of ament."""
    for name, needs in (("ros_core", "ros_environment"), ("ros_environment", "")):
        for kind, text in (("packages", ""), ("package_run_dependencies", needs)):
            marker = prefix / "share/ament_index/resource_index" / kind / name
            marker.parent.mkdir(parents=True, exist_ok=True)
            marker.write_text(text)
        folder = prefix / "share" / name / "environment"
        folder.mkdir(parents=True)
        (folder / "ament_prefix_path.dsv").write_text(AMENT)
        (folder.parent / "package.dsv").write_text(f"source;share/{name}/local_setup.sh")
        (folder.parent / "local_setup.dsv").write_text(
            f"source;share/{name}/environment/ament_prefix_path.sh"
        )
    (folder / "distro.dsv").write_text("set;ROS_DISTRO;jazzy")
    with open(folder.parent / "local_setup.dsv", "a") as file:
        file.write(f"\nsource;share/{name}/environment/distro.sh")
    return prefix


# ---- an environment that has the workspace already


def test_twice_is_as_once(tmp_path: Path):
    prefix = Prefix(tmp_path)
    prefix.add("a", path=AMENT, library=LIBRARY)
    prefix.add("b", ["a"], path=AMENT, python=PYTHON)
    once = environment(prefix.workspace, {"PATH": "/bin", "LD_LIBRARY_PATH": "/venv/lib"})
    assert environment(prefix.workspace, once) == once


def test_a_sourced_workspace_keeps_the_order_that_the_user_has_given(tmp_path: Path):
    prefix = Prefix(tmp_path)
    prefix.add("a", path=AMENT, python=PYTHON)
    sourced = environment(prefix.workspace, {})
    sourced["PYTHONPATH"] = f"/mine:{sourced['PYTHONPATH']}"
    assert environment(prefix.workspace, sourced) == sourced

    prefix.add("b", path=AMENT)  # built since then
    expected = f"{prefix.path}/b:{sourced['AMENT_PREFIX_PATH']}"
    assert environment(prefix.workspace, sourced)["AMENT_PREFIX_PATH"] == expected


def test_the_workspace_one_is_in_comes_before_another_that_was_sourced(tmp_path: Path):
    one, other = Prefix(tmp_path / "one"), Prefix(tmp_path / "other")
    for prefix in (one, other):
        prefix.add("pkg", path=AMENT)
    both = environment(other.workspace, environment(one.workspace, {}))
    assert both["AMENT_PREFIX_PATH"] == f"{other.path}/pkg:{one.path}/pkg"
    again = environment(one.workspace, both)
    assert again["AMENT_PREFIX_PATH"] == f"{one.path}/pkg:{other.path}/pkg"


def test_libraries_come_first_although_the_wheels_have_shuffled_them(tmp_path: Path):
    prefix = Prefix(tmp_path)
    prefix.add("a", library=LIBRARY)
    sourced = environment(prefix.workspace, {})
    sourced["LD_LIBRARY_PATH"] = f"/venv/lib:{prefix.path}/a/lib:/x"
    expected = f"{prefix.path}/a/lib:/venv/lib:/x"
    assert environment(prefix.workspace, sourced)["LD_LIBRARY_PATH"] == expected


# ---- what cannot be used


@pytest.mark.parametrize(
    "line", ["prepend-unique;PATH;bin", "set;X", "nonsense", "set;;x", "set;A$(B);x"]
)
def test_a_hook_that_nobody_knows_is_an_error_with_its_place(tmp_path: Path, line: str):
    prefix = Prefix(tmp_path)
    prefix.add("pkg", odd=f"# first\n{line}")
    with pytest.raises(WorkspaceError, match="is not an environment hook") as caught:
        environment(prefix.workspace, {})
    assert str(caught.value.where).endswith("share/pkg/hook/odd.dsv:2")


def test_a_path_with_a_colon_is_refused(tmp_path: Path):
    prefix = Prefix(tmp_path / "a:b")
    with pytest.raises(WorkspaceError, match="its path contains ':'"):
        environment(prefix.workspace, {})


def test_a_package_that_is_installed_in_part_is_left_out(tmp_path: Path):
    prefix = Prefix(tmp_path)
    (prefix.of("half") / "share").mkdir(parents=True)
    prefix.add("whole", path=AMENT)
    assert [*packages(str(prefix.path))] == ["whole"]
