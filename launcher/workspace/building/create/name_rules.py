"""Which names packages, nodes and maintainers may have."""

from __future__ import annotations

import keyword
import re
import sys
import sysconfig
import unicodedata
from collections.abc import Callable, Sequence
from functools import partial
from importlib.machinery import PathFinder
from itertools import filterfalse

from launcher.base.errors import UsageError
from launcher.workspace.building.create.templates import class_name

# rosidl accepts no other names, and REP 144 asks for two characters.
_NAME = re.compile(r"(?!.*__)[a-z][a-z0-9_]*[a-z0-9]")
_KEY = re.compile(r"[a-z0-9][a-z0-9_.+-]*")  # of a dependency: also rosdep's, as `python3-numpy`
# What catkin_pkg accepts, with which colcon reads package.xml.
_EMAIL = re.compile(
    r"[-a-zA-Z0-9_%+]+(\.[-a-zA-Z0-9_%+]+)*@[-a-zA-Z0-9%]+(\.[-a-zA-Z0-9%]+)*\.[a-zA-Z]{2,}"
)
# Modules that launch files import from the launcher, without being installed, and itself.
_LAUNCHER = ("launch", "launch_ros", "launch_xml", "launch_yaml", "launch_testing", "launcher")
_FOLDERS = ("build", "install", "log")
INTERFACES = "_interfaces"


def check_package(name: str, is_usable: Callable[[str], bool] = lambda _: True) -> None:
    """UsageError unless a package may have the name; it suggests another one if that is usable."""
    _check(name, "package", is_usable)
    if name in _FOLDERS:
        raise UsageError(
            f"'{name}' is a folder that colcon makes",
            hint=f"another name, for example {name}_nodes",
        )
    if name in sys.stdlib_module_names or name == "test":
        raise UsageError(
            f"'{name}' is a module of Python, which the package would hide",
            hint=f"another name, for example {name}_nodes",
        )


def check_nodes(names: Sequence[str]) -> None:
    """UsageError unless the nodes of one package may have these names."""
    for place, name in enumerate(names):
        others = {class_name(other) for other in (*names[:place], *names[place + 1 :])}
        _check(name, "node", partial(_has_own_class, others))
        if name in names[:place]:
            raise UsageError(f"the node '{name}' is given twice")

    classes = [class_name(name) for name in names]
    for place, name in enumerate(classes):
        if name in classes[:place]:
            both = f"'{names[classes.index(name)]}' and '{names[place]}'"
            raise UsageError(f"the nodes {both} would both be the class {name}")


def _has_own_class(others: set[str], name: str) -> bool:
    return class_name(name) not in others


def _check(name: str, what: str, is_usable: Callable[[str], bool]) -> None:
    if not _NAME.fullmatch(name):
        meant = _repaired(name)
        raise UsageError(
            f"'{name}' is not a valid name of a {what}: use at least two characters (lower-case "
            "letters, digits, single underscores), the first a letter, the last not an underscore",
            hint=f"did you mean '{meant}'?" if meant and is_usable(meant) else None,
        )
    if keyword.iskeyword(name):
        raise UsageError(
            f"'{name}' is a keyword of Python, and the name of a {what} is that of a module",
            hint=f"another name, for example {name}_{what}",
        )


def _repaired(name: str) -> str | None:
    """`my_robot` for `MyRobot` or `my-robot`; None if nothing valid is left of it."""
    plain = "".join(filterfalse(unicodedata.combining, unicodedata.normalize("NFKD", name)))
    if any(one.isalpha() and not one.isascii() for one in plain):
        return None  # without its `ß` a word is another one
    words = re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", plain)
    meant = re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_").lstrip("0123456789_")
    is_good = _NAME.fullmatch(meant) and not keyword.iskeyword(meant)
    return meant if is_good else None


def check_dependency(name: str) -> None:
    """UsageError unless a package.xml may name the dependency."""
    if not _KEY.fullmatch(name):
        raise UsageError(f"'{name}' is not the name of a package or of a rosdep key")


def check_line(option: str, text: str) -> None:
    """UsageError unless the text is one line that is not empty."""
    if not text.strip() or not text.isprintable():
        raise UsageError(f"{option}: {text!r} is not a line of text")


def is_email(text: str) -> bool:
    return _EMAIL.fullmatch(text) is not None


def module_in_environment(name: str) -> str | None:
    """Where Python finds an installed module of this name, which would be hidden; None: nowhere."""
    if name in _LAUNCHER:
        return "the launcher"
    paths = sysconfig.get_paths()
    spec = PathFinder.find_spec(name, [paths["purelib"], paths["platlib"]])
    return spec.origin if spec is not None else None
