"""YAML that is the same each time, with texts of several lines as blocks.

Texts are in quotes where another reader of YAML than PyYAML would take them for something else.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import yaml

from launcher.base.model.parameter_text import word_value
from launcher.base.yaml_dumper import Dumper


class _ExportDumper(Dumper):
    def increase_indent(self, flow: bool = False, indentless: bool = False) -> None:
        super().increase_indent(flow, indentless=False)


def _text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    is_misread = text.startswith("0o") or not isinstance(word_value(text), str)
    style = "|" if "\n" in text else "'" if is_misread else None
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_ExportDumper.add_representer(str, _text)


def document(data: Mapping[str, Any]) -> str:
    return yaml.dump(
        data,
        Dumper=_ExportDumper,
        sort_keys=False,
        default_flow_style=False,
        allow_unicode=True,
        width=1_000_000,
    )


def documents(every: Iterable[Mapping[str, Any]]) -> str:
    """Several documents in one text."""
    return "---\n".join(map(document, every))
