"""The pinned list, and which wheels a host can use."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from launcher.base.errors import LauncherError, UsageError
from launcher.hosts.sync import pinned_list, wheels
from launcher.hosts.sync.natives import Native, check, natives
from launcher.hosts.sync.on_host import pip_messages
from launcher.hosts.sync.pinned_list import PinnedList
from launcher.hosts.sync.release_tree import TreeEntry
from launcher.hosts.sync.wheels import PythonTarget

MARKERS = {"python_version": "3.12", "python_full_version": "3.12.3", "sys_platform": "linux"}
TARGET = PythonTarget(version=(3, 12), machine="x86_64", glibc=(2, 31), markers=MARKERS)

NOT_FOUND = "ERROR: No matching distribution found for "


def retry(why: str, package: str) -> str:
    """The warning of pip before it tries again, with or without success."""
    tries = "Retry(total=0, connect=None, read=None, redirect=None, status=None)"
    return f"WARNING: Retrying ({tries}) after connection broken by '{why}': /simple/{package}/\n"


def listed(*lines: str) -> PinnedList:
    return PinnedList(text="\n".join(lines), where="list.txt")


def house(folder: Path, *names: str) -> str:
    for name in names:
        (folder / name).write_bytes(b"")
    return str(folder)


# ---- the list


def test_markers_are_those_of_the_host():
    found = pinned_list.pins(
        listed(
            "numpy==2.2.6 ; python_full_version < '3.11'",
            "numpy==2.5.5 ; python_full_version >= '3.12'",
            "prompt-toolkit==3.0.53  # a comment",
        ),
        MARKERS,
    )

    assert [(pin.name, pin.version) for pin in found] == [
        ("numpy", "2.5.5"),
        ("prompt_toolkit", "3.0.53"),
    ]


def test_continued_lines_with_hashes():
    (pin,) = pinned_list.pins(listed("a==1 \\", "  --hash=sha256:12 \\", "  --hash=sha256:34"), {})

    assert (pin.version, pin.hashes) == ("1", ("sha256:12", "sha256:34"))


@pytest.mark.parametrize("line", ["a", "a>=1", "a==1.*", "a==1,==2"])
def test_a_version_that_is_not_exact_is_an_error(line: str):
    with pytest.raises(UsageError, match="has no exact version") as caught:
        pinned_list.pins(listed("# one", line), {})
    assert caught.value.where == "list.txt:2"


def test_what_is_no_requirement_is_an_error():
    with pytest.raises(UsageError, match="is no requirement"):
        pinned_list.pins(listed("a b c"), {})


@pytest.mark.parametrize("line", ["-r more.txt", "-e .", "./here", "--constraint=c.txt"])
def test_a_list_that_leads_to_other_files_is_an_error(tmp_path: Path, line: str):
    path = tmp_path / "list.txt"
    path.write_text(f"a==1\n{line}\n")

    with pytest.raises(UsageError, match="leads to files that the hosts do not have") as caught:
        pinned_list.read(str(path))
    assert caught.value.where == f"{path}:2"


def test_a_list_that_is_missing_is_an_error(tmp_path: Path):
    with pytest.raises(UsageError, match="No such file"):
        pinned_list.read(str(tmp_path / "none.txt"))


def test_comments_and_order_make_no_other_environment():
    assert listed("a==1", "b==2").digest == listed("# all", "b==2", "", "a==1 # x").digest
    assert listed("a==1").digest != listed("a==2").digest


@pytest.mark.parametrize(
    ("name", "file"),
    [("jazzy", "run.txt"), ("kilted", "run-kilted.txt"), (None, "run.txt")],
)
def test_the_list_of_a_checkout_is_that_of_the_distribution_in_use(
    monkeypatch: pytest.MonkeyPatch, name: str | None, file: str
):
    monkeypatch.setattr(pinned_list.distribution, "installed", lambda environ: name)

    found = pinned_list.default()
    assert found.where.endswith(f"/requirements/{file}")
    version = "9.1.2" if name == "kilted" else "7.1.6"
    assert f"ros-rclpy=={version}\n" in found.text


def test_a_distribution_without_wheels_has_no_packages_of_another_one(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(pinned_list.distribution, "installed", lambda environ: "lyrical")

    found = pinned_list.default()
    assert found.where == "the versions that are installed here"
    assert "rich==" in found.text
    assert "ros-" not in found.text


def test_without_a_checkout_the_installed_versions_are_the_list():
    lines = [*pinned_list._installed()]

    assert any(line.startswith("pyyaml==") for line in lines)
    assert any(line.startswith("ros-rclpy==") for line in lines)
    assert len({line.partition("==")[0].lower() for line in lines}) == len(lines)


# ---- wheels


@pytest.mark.parametrize(
    ("name", "fits"),
    [
        ("a-1.0-py3-none-any.whl", True),
        ("a-1.0-py2.py3-none-any.whl", True),
        ("a-1.0-cp312-cp312-manylinux_2_28_x86_64.whl", True),
        ("a-1.0-cp312-cp312-manylinux2014_x86_64.manylinux_2_17_x86_64.whl", True),
        ("a-1.0-cp38-abi3-manylinux_2_31_x86_64.whl", True),
        ("a-1.0-cp312-cp312-linux_x86_64.whl", True),
        ("a-1.0-cp312-cp312-manylinux_2_34_x86_64.whl", False),  # glibc
        ("a-1.0-cp311-cp311-manylinux_2_28_x86_64.whl", False),
        ("a-1.0-cp312-cp312-manylinux_2_28_aarch64.whl", False),
        ("a-1.0-cp312-cp312-musllinux_1_2_x86_64.whl", False),
        ("a-1.1-py3-none-any.whl", False),
        ("ab-1.0-py3-none-any.whl", False),
    ],
)
def test_what_a_host_can_use(tmp_path: Path, monkeypatch, name: str, fits: bool):
    monkeypatch.setattr(wheels, "_download", lambda *_: "no network")
    pins = pinned_list.pins(listed("A==1.0"), {})
    folder = house(tmp_path, name)

    if fits:
        assert wheels.chosen(folder, pins, TARGET) == [name]
    else:
        with pytest.raises(LauncherError, match=r"no wheel of a==1\.0 for Python 3\.12, x86_64"):
            wheels.chosen(folder, pins, TARGET)


def test_a_machine_without_a_network_is_told_at_once_for_all_hosts(tmp_path: Path, monkeypatch):
    """A pip that fails as without a network; it is not asked again."""
    asked = []

    def run(words: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        asked.append(words)
        text = f"{retry('NewConnectionError(...)', 'a')}{NOT_FOUND}a==1.0"
        return subprocess.CompletedProcess(words, 1, "", text)

    monkeypatch.setattr(wheels.subprocess, "run", run)
    monkeypatch.setattr(wheels, "_is_offline", False)
    pins = pinned_list.pins(listed("a==1.0"), {})
    said: list[str] = []
    for _ in range(2):
        with pytest.raises(LauncherError, match=r"pip reaches no index of packages from here"):
            wheels.chosen(str(tmp_path), pins, TARGET, said.append)

    assert len(asked) == 1
    assert said[0].startswith("downloads 1 wheel for Python 3.12, x86_64")


@pytest.mark.parametrize("why", ["ReadTimeoutError(...)", "NewConnectionError(...)"])
def test_a_warning_about_another_page_does_not_keep_pip_from_building_a_wheel(
    tmp_path: Path, monkeypatch, why: str
):
    """A try that was repeated, and a package that has no wheel for the host."""
    asked: list[str] = []

    def run(words: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        asked.append(words[3])
        if words[3] == "download":
            text = f"{retry(why, 'b')}{NOT_FOUND}A.a==1.0"
            return subprocess.CompletedProcess(words, 1, "", text)
        house(tmp_path, "a_a-1.0-py3-none-any.whl")
        return subprocess.CompletedProcess(words, 0, "", "")

    monkeypatch.setattr(wheels.subprocess, "run", run)
    monkeypatch.setattr(wheels, "_is_offline", False)
    house(tmp_path, "b-1.0-py3-none-any.whl")
    pins = pinned_list.pins(listed("a-a==1.0", "b==1.0"), {})

    files = wheels.chosen(str(tmp_path), pins, TARGET)

    assert files == ["a_a-1.0-py3-none-any.whl", "b-1.0-py3-none-any.whl"]
    assert asked == ["download", "wheel"]
    assert not wheels._is_offline


@pytest.mark.parametrize(
    ("text", "is_offline"),
    [
        (f"{retry('ReadTimeoutError(...)', 'a')}{NOT_FOUND}a==1.0 (from versions: none)", True),
        (f"{retry('NameResolutionError(...)', 'A.b')}{NOT_FOUND}a_b", True),
        (f"{retry('NewConnectionError(...)', 'simple')}{NOT_FOUND}a", False),
        (f"{retry('SSLError(...)', 'a')}{NOT_FOUND}a", False),
        (f"{retry('NewConnectionError(...)', 'a')}ERROR: No space left on device", False),
        ("ERROR: HTTPSConnectionPool(...): (Caused by NewConnectionError(...))", True),
        ("ERROR: Exception:\nTraceback ...\nReadTimeoutError: Read timed out.", False),
    ],
)
def test_what_a_pip_without_an_index_says(text: str, is_offline: bool):
    assert pip_messages.is_offline(text) == is_offline


def test_the_reason_of_an_error_inside_pip_is_its_last_line():
    assert wheels._reason("ERROR: Exception:\nTraceback ...\nOSError: no\n") == "OSError: no"


def test_the_wheel_for_the_newest_platform_is_taken(tmp_path: Path):
    names = [f"a-1.0-cp312-cp312-manylinux_2_{n}_x86_64.whl" for n in (17, 28, 34)]
    folder = house(tmp_path, "a-1.0-py3-none-any.whl", *names)

    assert wheels.chosen(folder, pinned_list.pins(listed("a==1.0"), {}), TARGET) == [names[1]]


def test_a_wheel_with_another_hash_is_not_used(tmp_path: Path, monkeypatch):
    monkeypatch.setattr(wheels, "_download", lambda *_: "")
    folder = house(tmp_path, "a-1.0-py3-none-any.whl")
    digest = wheels.digest_of(f"{folder}/a-1.0-py3-none-any.whl")
    right, wrong = (
        pinned_list.pins(listed(f"a==1.0 --hash=sha256:{text}"), {}) for text in (digest, "00")
    )

    assert wheels.chosen(folder, right, TARGET)
    with pytest.raises(LauncherError, match="has no wheel"):
        wheels.chosen(folder, wrong, TARGET)


def test_a_host_without_glibc_takes_no_manylinux():
    musl = PythonTarget(version=(3, 12), machine="x86_64", glibc=None, markers={})

    assert musl.platforms == ["linux_x86_64"]
    assert str(musl) == "Python 3.12, x86_64, no glibc"


# ---- compiled files


def native(**changes: object) -> Native:
    values = {"path": "install/lib/x.so", "machine": "x86_64", "glibc": 31, "python": None}
    return Native(**{**values, **changes})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"machine": "aarch64"}, "built for aarch64, and the host is x86_64"),
        ({"python": 11}, "built for Python 3.11, and the host's is 3.12"),
        ({"glibc": 34}, "needs glibc 2.34, and the host has 2.31"),
    ],
)
def test_a_file_that_a_host_cannot_load_is_an_error(changes: dict[str, object], message: str):
    with pytest.raises(LauncherError, match=message):
        check([native(**changes)], TARGET)


def test_a_file_that_fits_is_none():
    check([native(), native(python=12, glibc=17)], TARGET)


def test_compiled_files_are_recognized(tmp_path: Path):
    header = b"\x7fELF\x02\x01" + bytes(12) + (62).to_bytes(2, "little")
    (tmp_path / "x.so").write_bytes(header + b"\0GLIBC_2.2.5\0GLIBC_2.34\0GLIBC_2.4\0")
    (tmp_path / "text").write_text("GLIBC_2.99")
    path = "install/lib/python3.11/site-packages/x.so"
    entries = [
        TreeEntry(path=path, source=str(tmp_path / "x.so")),
        TreeEntry(path="t", source=str(tmp_path / "text")),
        TreeEntry(path="c", content=header),
    ]

    assert natives(entries) == [Native(path=path, machine="x86_64", glibc=34, python=11)]


@pytest.mark.parametrize(("name", "is_of_ros"), [("ros-action-msgs", True), ("numpy", False)])
def test_a_machine_without_wheels_of_ros_needs_an_installation(name: str, is_of_ros: bool):
    found = f"{NOT_FOUND}{name}==2.0.3 (from versions: none)\n{NOT_FOUND}{name}==2.0.3"
    assert ("install ROS 2 there" in pip_messages.advice(found)) == is_of_ros
