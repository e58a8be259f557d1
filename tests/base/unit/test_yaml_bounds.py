"""YAML of others: what is too deep or too large is an error of YAML, whoever reads it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from launcher.bag.converting import output_options
from launcher.bag.ros.bag_qos import read_overrides
from launcher.base import yaml_bounds
from launcher.base.document.document_reader import DocumentReader
from launcher.base.errors import LauncherError
from launcher.base.model import parameter_text
from launcher.language.ros.component_parameters import _from_file
from launcher.ros.helpers.parameter_check import file_parameters
from launcher.ros.messages import from_yaml
from launcher.run.watch.file_checks import error_in
from launcher.smoke.expect.steps import _value

DEEP = ["[" * 50_000, "{a: " * 3000 + "1" + "}" * 3000, "- " * 20_000 + "x"]


def repeated(levels: int) -> str:
    """Ten times the line before, in each line: 10^levels values."""
    lines = ["a0: &a0 [x]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, levels)]
    return "\n".join(lines)


@pytest.mark.parametrize("loader", [None, yaml.SafeLoader, yaml.BaseLoader])
@pytest.mark.parametrize("text", DEEP)
@pytest.mark.parametrize("read", [yaml_bounds.load, yaml_bounds.compose])
def test_deep_texts(read: Callable[..., object], text: str, loader: object):
    with pytest.raises(yaml.MarkedYAMLError, match="more than 100 levels"):
        read(text, loader)


def test_a_hundred_levels_are_read():
    value = yaml_bounds.load("[" * 100 + "]" * 100)
    for _ in range(99):
        (value,) = value
    assert value == []


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (repeated(9), "more than 1000000 values"),
        ("&a [*a]".ljust(200), "an entry contains itself"),
        ("&a {b: {c: *a}}".ljust(200), "an entry contains itself"),
        ("- " + ":".join(["59"] * 1000), "a number of more than 1000 characters"),
        ("x" * (16 * 1024 * 1024 + 1), "it has more than 16 MiB"),
    ],
)
def test_what_is_too_large(text: str, problem: str):
    with pytest.raises(yaml.YAMLError, match=problem):
        yaml_bounds.load(text)


@pytest.mark.parametrize(
    "text", [repeated(3), "a: &a 1\nb: *a", "x" * 5000, "- '" + "9" * 5000 + "'"]
)
def test_what_is_not(text: str):
    assert yaml_bounds.load(text) == yaml.safe_load(text)


@pytest.mark.parametrize("text", ["!!int x", "!!timestamp x", "!!bool x", "2001-99-99", "!!x y"])
def test_any_error_is_one_of_yaml(text: str):
    with pytest.raises(yaml.YAMLError):
        yaml_bounds.load(text)


# ---- all who read YAML of users


def of_file(read: Callable[[str], object]) -> Callable[[str, Path], object]:
    def reader(text: str, folder: Path) -> object:
        path = folder / "x.yaml"
        path.write_text(text)
        return read(str(path))

    return reader


def document(text: str) -> object:
    return DocumentReader(text, "x.yaml", what="a file", hint="").document()


REFUSING: dict[str, Callable[[str, Path], object]] = {
    "message": lambda text, _: from_yaml.value_of(text),
    "parameter value": lambda text, _: parameter_text.value_of(text),
    "parameter file": lambda text, _: parameter_text.read(text),
    "document": lambda text, _: document(text),
    "component parameters": of_file(lambda path: _from_file(Path(path), "/n")),
    "qos overrides": of_file(read_overrides),
    "output options": of_file(output_options.read),
    "step of smoke": lambda text, _: _value(text, yaml_bounds.load),
}


@pytest.mark.parametrize("text", DEEP)
@pytest.mark.parametrize("name", REFUSING)
def test_deep_texts_are_refused_everywhere(name: str, text: str, tmp_path: Path):
    with pytest.raises((yaml.YAMLError, LauncherError, ValueError)) as caught:
        REFUSING[name](text, tmp_path)
    assert "more than 100 levels" in str(caught.value)


@pytest.mark.parametrize("text", DEEP)
def test_deep_parameter_files_are_left_to_the_node(text: str, tmp_path: Path):
    path = tmp_path / "x.yaml"
    path.write_text(text)
    assert list(file_parameters(str(path), "/n")) == []
    error = error_in(str(path), is_parameters=True)
    assert error is not None
    assert "more than 100 levels" in error.message
