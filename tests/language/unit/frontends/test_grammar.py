"""The `$(...)` language of XML and YAML launch files."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from launcher.language.frontends.grammar import (
    MAX_DEPTH,
    GrammarError,
    Part,
    SubstitutionCall,
    Text,
    parse_template,
    unescape,
)

# A text is itself; a call is a list: the name, then a list of parts for each word.
CASES = {
    "": [""],
    "plain": ["plain"],
    "'quotes' are \"text\" (here)": ["'quotes' are \"text\" (here)"],
    "$0 and $1": ["$0 and $1"],
    "100 $": ["100 $"],
    r"\$(var a)": ["$(var a)"],
    r"a\\b": [r"a\b"],
    "$(dirname)": [["dirname"]],
    "$(env HOME)": [["env", ["HOME"]]],
    "$(env HOME /root)/x": [["env", ["HOME"], ["/root"]], "/x"],
    "$(env NOPE '')": [["env", ["NOPE"], []]],
    "pre$(var a)mid$(var b)": ["pre", ["var", ["a"]], "mid", ["var", ["b"]]],
    "$(var $(var a))": [["var", [["var", ["a"]]]]],
    "$(var a$(var b)c)": [["var", ["a", ["var", ["b"]], "c"]]],
    "$(eval '1 + 2')": [["eval", ["1 + 2"]]],
    "$(eval \"'a' == 'b'\")": [["eval", ["'a' == 'b'"]]],
    r"$(eval 'it\'s')": [["eval", ["it's"]]],
    "$(eval '$(var n) == 2')": [["eval", [["var", ["n"]], " == 2"]]],
    "$(command 'echo $(var b) $(dirname)')": [
        ["command", ["echo ", ["var", ["b"]], " ", ["dirname"]]]
    ],
    r"$(t \(a\) b\'c)": [["t", ["(a)"], ["b'c"]]],
    "$(t a$1)": [["t", ["a$1"]]],
    r'$(env "x_$(t \"y\")")': [["env", ["x_", ["t", ['"y"']]]]],
    "$(env \"x_$(t 'y')\")": [["env", ["x_", ["t", ["'y'"]]]]],
    "$(t line\nbreak)": [["t", ["line\nbreak"]]],
    "a) b": ["a) b"],
}

REJECTED = {
    "$(var a": (7, True),
    "$(": (2, True),
    "$()": (2, False),
    "$(1a)": (2, False),
    "$(var  two_spaces)": (6, False),
    "$(var trailing )": (15, False),
    "$( var a)": (2, False),
    "$(var 'a'b)": (9, False),
    "$(var a'b')": (7, False),
    "$(var (a))": (6, False),
    "$(var 'open)": (12, True),
    r"$(var 'open\')": (14, True),
    "$(var a\tb) $(": (13, True),
    "x $(eval '$(var a b) c)": (23, True),
}


def render_template(parts: Sequence[Part]) -> str:
    """A source text that parses to these parts again (neighbouring texts become one)."""
    return "".join(
        _escape(part.text, r"\$") if isinstance(part, Text) else _render_call(part, "")
        for part in parts
    )


def _render_call(call: SubstitutionCall, quote: str) -> str:
    words = [_render_word(word, quote) for word in call.words]
    return "$(" + " ".join([call.name, *words]) + ")"


def _render_word(word: Sequence[Part], quote: str) -> str:
    inner = quote or _quote_for(word)
    if quote:  # a word in a call between quotes cannot be quoted once more
        return "".join(_render_part(part, quote, rf"\$(){quote}") for part in word)
    if not inner:
        return "".join(_render_part(part, "", r"\$()'" + '"') for part in word)
    return inner + "".join(_render_part(part, inner, rf"\${inner}") for part in word) + inner


def _render_part(part: Part, quote: str, special: str) -> str:
    return _escape(part.text, special) if isinstance(part, Text) else _render_call(part, quote)


def _quote_for(word: Sequence[Part]) -> str:
    needs_quotes = not word or any(isinstance(p, Text) and " " in p.text for p in word)
    return "'" if needs_quotes else ""


def _escape(text: str, special: str) -> str:
    return "".join(f"\\{character}" if character in special else character for character in text)


def plain(parts: tuple[Part, ...]) -> list[object]:
    """The tree in the notation of the table."""
    return [
        part.text if isinstance(part, Text) else [part.name, *(plain(word) for word in part.words)]
        for part in parts
    ]


@pytest.mark.parametrize("source", CASES)
def test_template_is_read_as_ros_reads_it(source: str) -> None:
    assert plain(parse_template(source)) == CASES[source]


@pytest.mark.parametrize("source", REJECTED)
def test_error_names_the_character_where_it_went_wrong(source: str) -> None:
    with pytest.raises(GrammarError) as caught:
        parse_template(source)
    assert (caught.value.position, caught.value.at_end) == REJECTED[source]


def test_parts_know_their_place() -> None:
    parts = parse_template("ab$(var c)d")
    assert [part.position for part in parts] == [0, 2, 10]


def test_depth_is_bounded() -> None:
    deep = "$(not " * (MAX_DEPTH + 1) + "true" + ")" * (MAX_DEPTH + 1)
    with pytest.raises(GrammarError, match="nested"):
        parse_template(deep)
    assert parse_template(deep[len("$(not ") : -1])


def test_unescape_takes_one_level() -> None:
    assert unescape(r"\$ \\ \'") == r"$ \ '"


def test_long_text_is_parsed_quickly() -> None:
    text = "\\" * 50_000 + "'" * 50_000 + "$" * 50_000
    assert plain(parse_template(text)) == [unescape(text)]


def merged(parts: tuple[Part, ...]) -> list[object]:
    """`plain`, neighbouring texts made one: printing cannot keep them apart."""
    tree: list[object] = []
    for part in parts:
        if isinstance(part, SubstitutionCall):
            tree.append([part.name, *(merged(word) for word in part.words)])
        elif tree and isinstance(tree[-1], str):
            tree[-1] += part.text
        else:
            tree.append(part.text)
    return tree


_NAMES = st.sampled_from(["var", "env", "find-pkg-share", "a_1"])
_TEXTS = st.text(st.sampled_from("ab1 $()'\"/-_\n\u00fc"), min_size=1, max_size=6)


def _calls(inner: st.SearchStrategy[SubstitutionCall]) -> st.SearchStrategy[SubstitutionCall]:
    # Within quotes a nested call cannot have words with spaces, so nested words have none.
    bare = _TEXTS.map(lambda text: text.replace(" ", "_"))
    parts = st.lists(st.builds(Text, bare, st.just(0)) | inner, min_size=1, max_size=3).map(tuple)
    return st.builds(SubstitutionCall, _NAMES, st.lists(parts, max_size=2).map(tuple), st.just(0))


_NESTED = st.recursive(
    st.builds(SubstitutionCall, _NAMES, st.just(()), st.just(0)), _calls, max_leaves=6
)
_WORDS = st.lists(
    st.lists(st.builds(Text, _TEXTS, st.just(0)) | _NESTED, max_size=3).map(tuple), max_size=3
).map(tuple)
_TEMPLATES = st.lists(
    st.builds(Text, _TEXTS, st.just(0)) | st.builds(SubstitutionCall, _NAMES, _WORDS, st.just(0)),
    min_size=1,
    max_size=4,
).map(tuple)


@given(_TEMPLATES)
def test_what_is_printed_is_read_back(parts: tuple[Part, ...]) -> None:
    assert merged(parse_template(render_template(parts))) == merged(parts)


@given(st.text(st.sampled_from("a $()'\"\\v\n"), max_size=20))
@example(r"a\$(b)")
@example("$(v 'a $(v \\( b)')")
def test_parse_then_print_is_stable(source: str) -> None:
    try:
        parts = parse_template(source)
    except GrammarError:
        return
    printed = render_template(parts)
    assert merged(parse_template(printed)) == merged(parts)
    assert render_template(parse_template(printed)) == printed
