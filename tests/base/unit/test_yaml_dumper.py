"""What is written as YAML is read back as it was."""

from __future__ import annotations

from typing import Any

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from launcher.base.yaml_dumper import Dumper

texts = st.text(max_size=20) | st.text("\x85\u2028\u2029\n ", max_size=4)


@pytest.mark.parametrize("is_flow", [False, True])
@example({"a\x85b": "\x85", "\u2028": "\ufeff", "\n": "\t"})
@given(st.dictionaries(texts, texts | st.lists(texts)))
def test_every_text_comes_back(is_flow: bool, values: dict[str, Any]):
    written = yaml.dump(values, Dumper=Dumper, allow_unicode=True, default_flow_style=is_flow)
    assert yaml.safe_load(written) == values
