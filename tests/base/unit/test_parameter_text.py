"""Parameters as YAML: texts stay texts, words without quotes are what rcl takes them for."""

from __future__ import annotations

import enum
import math
from typing import Any

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from launcher.base.model.parameter_text import (
    ExponentText,
    file_text,
    rcl_loader,
    read,
    rule,
    value_of,
    value_text,
    word_value,
)

WORDS: dict[str, Any] = {
    "0483": 483.0,
    "0123": 83,
    "-017": -15,
    "+1": 1,
    "0x1F": 31,
    "0x1p3": 8.0,
    "0x.8": 0.5,
    "9223372036854775807": 9223372036854775807,
    "9223372036854775808": 9223372036854775808.0,
    "1e5": 100000.0,
    "1.": 1.0,
    "-.5": -0.5,
    "1e400": "1e400",
    "1e-310": "1e-310",
    "0e5": 0.0,
    "y": True,
    "OFF": False,
    "yEs": "yEs",
    "inf": math.inf,
    "-Infinity": -math.inf,
    "+.inf": math.inf,
    "-.nan": "-.nan",
    "null": "null",
    "~": "~",
    "1_000": "1_000",
    "0o17": "0o17",
    "1:30": "1:30",
    "2026-01-01": "2026-01-01",
    "1f": "1f",
    ".": ".",
}


@pytest.mark.parametrize(("word", "value"), [*WORDS.items(), ("", "")])
def test_a_word_without_quotes_is_what_rcl_takes_it_for(word: str, value: Any):
    found = word_value(word)
    assert (type(found), found) == (type(value), value)


@pytest.mark.parametrize("word", ["nan", "NaN", ".nan", "nan(12)", "-nan"])
def test_words_for_no_number(word: str):
    assert math.isnan(float(word_value(word)))


texts = st.text(max_size=20) | st.from_regex(r"[-+.0-9eExXypn_: ~#]{0,8}", fullmatch=True)
scalars = texts | st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False)


@example({"a\x85b": "\x85", "\u2028": "\ufeff", "\n": "\t"})
@given(st.dictionaries(texts, scalars | st.lists(texts, min_size=1)))
def test_files_and_rules_keep_texts(values: dict[str, Any]):
    content = {"/**": {"ros__parameters": values}}
    assert yaml.safe_load(file_text(content)) == content
    parameters = read(file_text(content))["/**"]["ros__parameters"]
    assert list(parameters) == list(values)
    for name, value in values.items():
        if not isinstance(value, float):  # of which rcl does not take the smallest
            assert parameters[name] == value
            assert yaml.safe_load(value_text(value)) == value
            assert read(value_text(value)) == value


def test_a_rule_has_quotes_only_where_it_needs_them():
    assert rule("a", "text") == "a:=text"
    assert rule("a", "0483") == "a:='0483'"
    assert rule("a", "") == "a:=''"
    assert rule("a", [1, 2]) == "a:=- 1\n- 2"


def test_a_number_without_a_point_is_a_text_that_has_quotes_only_in_a_file():
    found = value_of("[1e5, 1.5e3, '1e5', 2.5e+3]")
    assert found == ["1e5", "1.5e3", "1e5", 2500.0]
    assert [type(one) for one in found] == [ExponentText, ExponentText, str, float]
    assert file_text({"a": found[0], "b": found[2]}) == 'a: "1e5"\nb: "1e5"\n'
    assert (rule("a", found[0]), rule("a", found[2])) == ("a:=1e5", "a:='1e5'")


def test_values_of_subclasses_are_written_as_their_base():
    class Mode(str, enum.Enum):
        FAST = "y"

    class Count(enum.IntEnum):
        TWO = 2

    assert file_text({"mode": Mode.FAST, "count": Count.TWO}) == 'mode: "y"\ncount: 2\n'


@pytest.mark.parametrize(
    "text",
    ["!", "1\t", "a: >#", "[a?'']", "\n\ufeffa", "{a: b # ?\n, c: !}", "'a # b'\t", "{' # ': ! }"],
)
def test_texts_are_read_as_pyyaml_reads_them_where_the_c_library_does_not(text: str):
    def found(load: Any) -> Any:
        try:
            return load(text)
        except yaml.YAMLError as error:
            return str(error)

    assert found(value_of) == found(yaml.safe_load)
    assert found(read) == found(lambda text: yaml.load(text, rcl_loader()))
