"""Launch files that are not YAML, or do not mean what was meant."""

from __future__ import annotations

import textwrap

from tests.launch.unit.classic_mistakes.cases import Case


def yaml(text: str, line: int, at: str, message: str, hint: str) -> Case:
    return Case(textwrap.dedent(text), line, at, message, hint, suffix="yaml")


ERRORS = {
    "a tab": yaml(
        "launch:\n- executable:\n\tcmd: ls\n",
        3,
        "\tcmd",
        "a tab at the beginning of a line",
        "indent with spaces",
    ),
    "a key that is indented less than its neighbour": yaml(
        "launch:\n- executable:\n    cmd: ls\n   output: screen\n",
        4,
        "output",
        "this line is indented by 3 spaces, line 3 by 4",
        "begin it with 4 spaces, like line 3",
    ),
    "an item that is indented less than its neighbour": yaml(
        "launch:\n  - executable:\n      cmd: ls\n - log:\n     message: x\n",
        4,
        "- log",
        "this line is indented by 1 space, line 2 by 2",
        "begin it with 2 spaces, like line 2",
    ),
    "a key that is indented further than its neighbour": yaml(
        "launch:\n- log:\n    message: x\n      level: INFO\n",
        4,
        ": INFO",
        "this line is indented further than the key above, which has a value",
        "indent it like line 3: with 4 spaces",
    ),
    "attributes beside their action": yaml(
        "launch:\n- node:\n  pkg: demo\n  exec: x\n",
        3,
        "pkg",
        "'pkg' is beside 'node' instead of below it",
        "indent the attributes of 'node' further than 'node' itself",
    ),
    "items at the level of launch": yaml(
        " launch:\n- log:\n    message: x\n",
        2,
        "- log",
        "this line belongs to no block above",
        "indent it by the same number of spaces as the line above",
    ),
    "a key without colon": yaml(
        "launch:\n- executable:\n    cmd: ls\n    output screen\n    name: x\n",
        4,
        "output",
        "this line has no ':' after its key",
        "write 'output: screen'",
    ),
    "an action without colon": yaml(
        "launch:\n- log\n    message: x\n",
        3,
        ": x",
        "a key in a value: the line above has no ':' at its end",
        "write '- log:' in line 2",
    ),
    "a colon in a value": yaml(
        "launch:\n- log:\n    message: now: x\n",
        3,
        ": x",
        "the value holds a ':', as if it were a key",
        "put the value in quotes",
    ),
    "an open quote": yaml(
        'launch:\n- log:\n    message: "x\n- log:\n    message: y\n',
        3,
        '"x',
        "the quote that begins here has no end",
        "add the closing quote",
    ),
    "text behind a quote": yaml(
        'launch:\n- log:\n    message: "x" y\n',
        3,
        "y",
        "there is text behind the end of a value",
        "put the value in quotes",
    ),
    "an open brace": yaml(
        "launch:\n- log: {message: x\n- log:\n    message: y\n",
        2,
        "{message",
        "the '{' that begins here has no '}'",
        "add '}'",
    ),
    "a value that begins with @": yaml(
        "launch:\n- log:\n    message: @x\n",
        3,
        "@x",
        "a value cannot begin with '@'",
        "put the value in quotes",
    ),
    "a value that begins with *": yaml(
        "launch:\n- log:\n    message: *x\n",
        3,
        "*x",
        "'*x' stands for an anchor, and there is no '&x' above",
        "put the value in quotes if it is a text",
    ),
    "a value that begins with !": yaml(
        "launch:\n- log:\n    message: !x y\n",
        3,
        "!x",
        "a value that begins with '!' is a YAML tag, and '!x' is none",
        "put the value in quotes",
    ),
    "a backslash": yaml(
        'launch:\n- log:\n    message: "\\d"\n',
        3,
        'd"',
        "'\\d' means nothing in double quotes",
        "write two backslashes, or put the value in single quotes",
    ),
    "a list in the line of its key": yaml(
        "launch: - log:\n    message: x\n",
        1,
        "- log",
        "a list cannot begin in the line of its key",
        "begin the list in the next line, indented further than its key",
    ),
    "two documents": yaml(
        "launch: []\n---\nlaunch: []\n",
        2,
        "---",
        "a second document begins here",
        "a launch file is one document: remove '---'",
    ),
}
