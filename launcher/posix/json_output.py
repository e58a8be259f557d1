"""What `--json` prints: the only place where verbs write JSON to standard output.

An answer is one object with a `version`, the number of its form (docs/reference/json.md). Verbs
that print while something goes on print such an object on each line.
"""

from __future__ import annotations

from collections.abc import Mapping

from launcher.base import strict_json
from launcher.posix.stdio import can_print, print_text

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

# Of every form that has no separate number. It is raised if a key is removed or renamed, or means
# something else; new keys do not raise it.
VERSION = 1

_BEYOND_LATIN = "\u2500"


def print_document(document: Mapping[str, Any]) -> None:
    """Print the whole answer of a verb; a closed pipe is ignored."""
    print_text(_text(document, indent=2))


def print_line(document: Mapping[str, Any]) -> None:
    """Print one of the answers of a verb that goes on."""
    print(json_line(document), flush=True)


def json_line(document: Mapping[str, Any]) -> str:
    """The same as a text, for verbs that print several at once."""
    return _text(document)


def _text(document: Mapping[str, Any], **style: Any) -> str:
    """With escapes where the output lacks characters: they would be replaced."""
    complete = {"version": VERSION, **document}
    return strict_json.dumps(complete, ensure_ascii=not can_print(_BEYOND_LATIN), **style)
