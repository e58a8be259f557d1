"""The fleet's expectation files satisfy the loader and the schema."""

from __future__ import annotations

from pathlib import Path

import jsonschema
import pytest
import yaml

from launcher.smoke.expect.expectation_entries import json_schema
from launcher.smoke.preflight import loader
from tests.support.repository import REPOSITORY

FILES = sorted((REPOSITORY / "launch").glob("*.expect.yaml"))


def test_there_is_a_normal_run_a_stall_and_a_warehouse():
    names = ["stall.expect.yaml", "system.expect.yaml", "warehouse.expect.yaml"]
    assert [path.name for path in FILES] == names


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_a_file_is_understood_and_names_its_schema(path: Path):
    script = loader.load(str(path))
    names = [expectation.name for expectation in script.completed().expectations]
    assert len(names) == len(set(names)) > 20
    assert script.run_time_s() <= 30.0  # both together stay well inside what CI has
    first = path.read_text(encoding="utf-8").splitlines()[0]
    schema = path.parent / first.rpartition("$schema=")[2]
    assert schema.resolve() == REPOSITORY / "launcher" / "smoke" / "expectations.schema.json"


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_a_file_satisfies_the_schema(path: Path):
    document = yaml.safe_load(path.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(json_schema()).validate(document)


def test_the_file_beside_the_launch_file_is_the_normal_run():
    assert loader.beside(str(REPOSITORY / "launch" / "system.launch.py")) == FILES[1]
