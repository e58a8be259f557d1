"""Finding the launch file for the target on the command line."""

from pathlib import Path

import pytest

from launcher.base.errors import PackageNotFoundError, UsageError
from launcher.language.frontends.locate import locate


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project with one launch file; the working directory is inside it."""
    # Not tmp_path itself: beside that are the folders of other tests, which may have packages.
    folder = tmp_path / "project"
    (folder / "launch").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>demo</name></package>")
    (folder / "launch" / "plant.launch.py").touch()
    (folder / "src").mkdir()
    monkeypatch.chdir(folder / "src")
    return folder


@pytest.fixture
def prefix(tmp_path: Path) -> dict[str, str]:
    """An environment whose ament index holds the package `shop`."""
    root = tmp_path / "prefix"
    marker = root / "share/ament_index/resource_index/packages/shop"
    marker.parent.mkdir(parents=True)
    marker.touch()
    launch = root / "share/shop/launch"
    launch.mkdir(parents=True)
    (launch / "till.launch.xml").touch()
    return {"AMENT_PREFIX_PATH": str(root)}


def test_a_path_is_taken_as_it_is(project):
    assert locate(["../launch/plant.launch.py"], {}).samefile(project / "launch/plant.launch.py")


def test_a_name_is_found_in_the_project_around_the_working_directory(project):
    assert locate(["plant"], {}) == project / "launch" / "plant.launch.py"


def test_a_name_is_found_in_an_installed_package(project, prefix):
    assert locate(["till"], prefix).name == "till.launch.xml"


def test_package_and_file_are_looked_up_as_ros2_launch_does(project, prefix):
    assert locate(["shop", "till.launch.xml"], prefix).parent.name == "launch"


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["plnat"], "did you mean 'plant'?"),
        (["../launch/plan.launch.py"], "did you mean 'plant.launch.py'?"),
        (["../launch/shop.launch.py"], "available: plant.launch.py"),
        (["shop", "til.launch.xml"], "did you mean 'till.launch.xml'?"),
        (["shop", "till.launch"], "did you mean 'till.launch.xml'?"),
        (["shop", "till.py"], "did you mean 'till.launch.xml'?"),
    ],
)
def test_a_misspelt_target_gets_the_nearest_one(project, prefix, words, hint):
    with pytest.raises(UsageError) as caught:
        locate(words, prefix)
    assert caught.value.hint == hint


def test_all_files_that_a_name_without_its_suffix_may_mean_are_offered(project):
    for name in ("go.launch.py", "go.launch.xml"):
        Path(name).touch()
    with pytest.raises(UsageError) as caught:
        locate(["go.launch"], {})
    assert caught.value.hint == "did you mean 'go.launch.py' or 'go.launch.xml'?"


def test_a_launch_file_here_is_offered_for_its_name(project, prefix):
    Path("demo.launch.py").touch()
    with pytest.raises(UsageError) as caught:
        locate(["demo"], prefix)
    assert caught.value.hint == "did you mean 'demo.launch.py'?"


@pytest.mark.parametrize(
    ("folder", "target", "near"),
    [
        (".", "plant.launch.py", "launch/plant.launch.py"),
        ("launch", "launch/plant.launch.py", "plant.launch.py"),
        ("deep", "plant.launch.py", "../launch/plant.launch.py"),
        ("deep", "../plant.launch.py", "../launch/plant.launch.py"),
        (".", "plan.launch.py", "launch/plant.launch.py"),
        (".", "plant.launch", "launch/plant.launch.py"),
        ("launch", "plant.launch", "plant.launch.py"),
        ("launch", "./plant.xml", "plant.launch.py"),
        (".", "shop.launch.py", None),
    ],
)
def test_a_file_in_the_launch_folder_is_offered(project, monkeypatch, folder, target, near):
    (project / "deep").mkdir(exist_ok=True)
    monkeypatch.chdir(project / folder)
    with pytest.raises(UsageError) as caught:
        locate([target], {})
    wanted = f"did you mean '{near}'?" if near else "available: launch/plant.launch.py"
    assert caught.value.hint == wanted


@pytest.mark.parametrize("target", ["plant", "till", "../launch/plant.launch.py"])
def test_a_word_behind_a_launch_file_is_taken_for_an_argument_without_a_value(
    project, prefix, target
):
    with pytest.raises(UsageError, match="malformed launch argument 'debug'") as caught:
        locate([target, "debug"], prefix)
    assert caught.value.hint == "did you mean debug:=VALUE?"


def test_a_misspelt_package_gets_the_nearest_one(project, prefix):
    with pytest.raises(PackageNotFoundError) as caught:
        locate(["shopp", "till.launch.xml"], prefix)
    assert caught.value.hint == "did you mean 'shop'?"


def test_a_name_that_two_packages_have_is_not_guessed(project, prefix):
    other = Path(prefix["AMENT_PREFIX_PATH"]) / "share/other/launch"
    other.mkdir(parents=True)
    (other / "till.launch.py").touch()
    with pytest.raises(UsageError, match="is ambiguous"):
        locate(["till"], prefix)
