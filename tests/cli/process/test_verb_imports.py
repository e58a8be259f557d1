"""What verbs import: what they use, and nothing that takes long to import."""

from __future__ import annotations

import pytest

from tests.support.loaded_modules import loaded_modules

# Each takes 3 to 30 ms.
LARGE = {
    *("dataclasses", "email.message", "hashlib", "importlib.metadata", "inspect", "psutil"),
    *("rclpy", "urllib.request", "xml.etree.ElementTree", "yaml"),
}


@pytest.mark.parametrize(
    ("words", "used", "most"),
    [
        ("--help", set(), 70),
        ("ps", set(), 70),
        ("topic list --help", {"dataclasses", "inspect"}, 50),
        ("pkg list", set(), 35),
        ("smoke --help", set(), 45),
        ("plan system", set(), 130),
        ("launch --help", set(), 40),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_verb_imports_what_it_uses(words: str, used: set[str], most: int):
    modules = loaded_modules(*words.split()).names
    assert modules & LARGE == used
    ours = sorted(name for name in modules if name.partition(".")[0] == "launcher")
    assert len(ours) <= most, ours
