"""Parameters as YAML from which rcl reads the types that they have here.

rcl takes more unquoted words for a boolean or a number than PyYAML, which writes `1e5`, `nan`, `y`
and `0483` without quotes.
"""

from __future__ import annotations

import functools
import re

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_TRUE = ("y", "Y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON")
_FALSE = ("n", "N", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF")
_NUMBER = re.compile(
    r"""[-+]?(
        (?P<whole>0[xX][0-9a-fA-F]+|[0-9]+)
      | ([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?
      | 0[xX]([0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)([pP][-+]?[0-9]+)?
      | (?P<named>(?i:inf|infinity|nan(\([0-9a-z_]*\))?)
                  | \.(inf|Inf|INF) | (?<![-+])\.(nan|NaN|NAN))
    )""",
    re.VERBOSE,
)
_EXPONENT = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)[eE][-+]?[0-9]+$")
# What libyaml and PyYAML's own reader take for different things: tabs, `?` in braces, a lone `!`, a
# comment behind `|`, and marks and ends of lines beyond those of ASCII; unless it is in a comment.
# What looks like a comment may be within quotes: from the next quotation mark on, it is kept.
_READ_DIFFERENTLY = re.compile(r"[\t?\r\x85\u2028\u2029\ufeff]|!(?![\w!])|[|>][-+0-9]*#")
_COMMENT = re.compile(r"""(?:^|(?<=[ \t]))#[^'"\n\r\x85\u2028\u2029\ufeff]*(['"].*)?""", re.M)
_INT64 = (-(2**63), 2**63 - 1)
_SMALLEST = 2.0**-1022  # `strtod` reports an underflow for smaller ones
_TAG, _WORD = "!exponent", "!word"
_QUOTES = ("'", '"')
_STRING = "tag:yaml.org,2002:str"
# Tags that rcl ignores: the word decides.
_IGNORED = tuple(f"tag:yaml.org,2002:{name}" for name in ("bool", "int", "float", "null"))


class ExponentText(str):
    """A text of a launch file, without a type, in which rcl sees a number: `1e-3`, `2E6`.

    PyYAML requires a point in front of the exponent. As in ROS 2, it stays a text in the launch
    file; behind `-p` the node gets a number, in a parameter file since Kilted the text.
    """

    __slots__ = ()


def file_text(content: object) -> str:
    """A parameter file with this content; every text that is a value is in quotes.

    Jazzy leaves the quotes out of ExponentText, and a node with a text parameter then ends.
    """
    import yaml

    text: str = yaml.dump(
        content,
        Dumper=_dumper(quotes_all=True),
        default_flow_style=False,
        sort_keys=False,
        allow_unicode=True,
        width=float("inf"),
    )
    return text


def value_text(value: object) -> str:
    """A YAML document with this value; a text is in quotes where it needs them."""
    import yaml

    text: str = yaml.dump(value, Dumper=_dumper(quotes_all=False), width=float("inf"))
    return text


def rule(name: str, value: object) -> str:
    """The word behind `-p`."""
    # PyYAML ends a scalar document with `...`.
    text = value_text(value).rstrip("\n").removesuffix("\n...")
    return f"{name}:={text}"


def value_of(text: str) -> Any:
    """The value of a text of the launch file by YAML's rules; raises yaml.YAMLError."""
    return _load(text, 0)


def read(text: str) -> Any:
    """The content of a parameter file, with the types that rcl reads; raises yaml.YAMLError."""
    return _load(text, 1)


def _load(text: str, kind: int) -> Any:
    """The value of a text, by PyYAML's rules (0) or those of rcl (1).

    A launch has thousands of parameters, and the C library reads them ten times faster. The other
    reader has those texts that the two read differently, and the words for errors.
    """
    import yaml

    from launcher.base import yaml_bounds

    if hasattr(yaml, "CSafeLoader") and not _is_read_differently(text):
        try:
            return yaml_bounds.load(text, _loaders(yaml.CSafeLoader)[kind])
        except yaml.YAMLError:
            pass
    return yaml_bounds.load(text, _loaders(yaml.SafeLoader)[kind])


def _is_read_differently(text: str) -> bool:
    found = _READ_DIFFERENTLY.search
    return found(text) is not None and found(_COMMENT.sub(r"\1", text)) is not None


def rcl_loader() -> Any:
    """The loader of PyYAML that gives values the types that rcl reads; it takes `!!binary`, too."""
    import yaml

    return _loaders(yaml.SafeLoader)[1]


def word_value(word: str) -> bool | int | float | str:
    """What rcl takes a word without quotes for."""
    if word in _TRUE or word in _FALSE:
        return word in _TRUE
    found = _NUMBER.fullmatch(word)
    if found is None:
        return word
    if found["named"]:
        sign = -1.0 if word[0] == "-" else 1.0
        return sign * float(found["named"].lstrip(".").partition("(")[0])
    whole = _whole(word) if found["whole"] else None
    return _double(word) if whole is None else whole


def _whole(word: str) -> int | None:
    """As `strtol` reads it; None if it does not."""
    digits = word.lstrip("+-")
    is_octal = len(digits) > 1 and digits[0] == "0" and digits[1] not in "xX"
    try:
        number = int(word, 8 if is_octal else 0)
    except ValueError:
        return None
    return number if _INT64[0] <= number <= _INT64[1] else None


def _double(word: str) -> float | str:
    """As `strtod` reads it; the word if that has no such number."""
    try:
        if "x" in word.lower():
            return float.fromhex(word)
    except OverflowError:
        return word
    number = float(word)
    is_zero = not re.search("[1-9]", re.split("[eE]", word)[0])
    return number if is_zero or _SMALLEST <= abs(number) < float("inf") else word


@functools.cache
def _dumper(*, quotes_all: bool) -> Any:
    from launcher.base import yaml_dumper

    class ParameterDumper(yaml_dumper.Dumper):
        def represent_mapping(self, *words: Any, **named: Any) -> Any:
            node = super().represent_mapping(*words, **named)
            for key, _ in node.value:
                key.style = None  # names are texts in any case
            return node

    def represent_text(dumper: Any, text: str) -> Any:
        needs_quotes = not isinstance(word_value(text), str)
        style = '"' if quotes_all else "'" if needs_quotes else None
        return dumper.represent_scalar(_STRING, str.__str__(text), style=style)

    ParameterDumper.add_representer(str, represent_text)
    if not quotes_all:
        ParameterDumper.add_representer(
            ExponentText, lambda dumper, text: dumper.represent_scalar(_STRING, str.__str__(text))
        )
    # Of subclasses, such as enumerations and the numbers of numpy.
    ParameterDumper.add_multi_representer(str, represent_text)
    ParameterDumper.add_multi_representer(
        int, lambda dumper, value: dumper.represent_int(int(value))
    )
    ParameterDumper.add_multi_representer(
        float, lambda dumper, value: dumper.represent_float(float(value))
    )
    return ParameterDumper


@functools.cache
def _loaders(base: Any) -> tuple[Any, Any]:
    """PyYAML's rules, with ExponentText, and those of rcl, for one of its safe loaders."""
    import yaml

    class WithExponents(base):  # type: ignore[misc]  # no class for the type checker
        pass

    class OfRcl(base):  # type: ignore[misc]
        def resolve(self, kind: Any, value: Any, implicit: Any) -> Any:
            resolved: Any = super().resolve
            return _WORD if kind is yaml.ScalarNode else resolved(kind, value, implicit)

        def construct_mapping(self, node: Any, deep: bool = False) -> Any:
            for key, _ in node.value:
                key.style = key.style or '"'  # names are texts in any case
            return super().construct_mapping(node, deep)

    def of_word(loader: Any, node: Any) -> Any:
        text = loader.construct_scalar(node)
        return text if node.style in _QUOTES else word_value(text)

    WithExponents.add_implicit_resolver(_TAG, _EXPONENT, list("-+.0123456789"))
    WithExponents.add_constructor(_TAG, lambda loader, node: ExponentText(node.value))
    for tag in (_WORD, *_IGNORED):
        OfRcl.add_constructor(tag, of_word)
    return WithExponents, OfRcl
