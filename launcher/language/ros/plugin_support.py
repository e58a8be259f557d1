"""Plug-in versions: the check that extensions of nodes make of themselves."""

from __future__ import annotations

import re

from launcher.language.naming import public


@public("launch_ros.utilities.plugin_support")
class PluginException(Exception):
    """A plug-in does not fit."""


def satisfies_version(version: str, caret_range: str) -> None:
    """PluginException unless `version` fits a range like `^0.1`: same major, not older."""
    if not caret_range.startswith("^"):
        raise ValueError("only caret ranges are supported, like ^0.1")
    wanted, given = (_numbers(text) for text in (caret_range[1:], version))
    if given[0] != wanted[0] or given < wanted:
        raise PluginException(f"version {version} does not satisfy {caret_range}")


def _numbers(text: str) -> list[int]:
    if not re.fullmatch(r"\d+(\.\d+){0,2}", text):
        raise ValueError(f"'{text}' is no version number")
    return [int(part) for part in text.split(".")]
