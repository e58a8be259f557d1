"""Values of loops that are no sets of fields, and lengths that are no numbers."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.launch.plan.planner import make_plan
from tests.language.unit.test_errors import HEAD


@pytest.mark.parametrize(
    ("part", "message", "hint"),
    [
        ("x", "'x' of values is no mapping", "write {name: x}"),
        ("[1, 2]", "'[1, 2]' of values is no mapping", "write {name: [1, 2]}"),
        ("5", "'5' of values is no mapping", "write {name: 5}"),
        ("{1: 2}", "the name 1 in '{1: 2}' of values is not a text", "write {'1': ...}"),
        ("{b: ", "'{b:' of values is not valid YAML: ", "values are written {name: value, "),
    ],
)
def test_what_is_no_set_of_fields_of_a_loop_is_named(
    part: str, message: str, hint: str, tmp_path: Path
):
    file = tmp_path / "a.launch.xml"
    file.write_text(f'<launch>\n<for_each values="{{a: 1}};{part}"/></launch>')
    python = tmp_path / "b.launch.py"
    call = f"ForEach('{{a: 1}};' {part!r}, function=lambda **fields: [])"
    python.write_text(f"{HEAD}    return LaunchDescription([{call}])\n")

    for path, name in ((file, "values"), (python, "input_values")):
        error = make_plan(str(path), []).error
        assert error is not None
        line = {file: 2, python: 7}[path]
        assert error.fault.where == f"{path}:{line}"
        assert error.fault.message.startswith(message.replace("values", name))
        assert (error.fault.hint or "").startswith(hint.replace("values", name))


@pytest.mark.parametrize("length", ["x", "1.5", ""])
def test_a_length_of_a_loop_that_is_no_number_is_named(length: str, tmp_path: Path):
    file = tmp_path / "a.launch.xml"
    file.write_text(f'<launch><for len="{length}" name="i"/></launch>')

    error = make_plan(str(file), []).error

    assert error is not None
    assert error.fault.message == f"len is '{length}', which is not a whole number"
