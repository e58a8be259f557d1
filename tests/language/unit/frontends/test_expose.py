"""Tags and substitutions of third-party packages."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from launcher.language import frontend_registry
from launcher.language.compat import vocabulary
from launcher.language.frontends import expose
from launcher.language.frontends.errors import FrontendError
from launcher.language.frontends.xml import XmlParser

PACKAGE = """
from typing import List

from launch.action import Action
from launch.actions import ExecuteProcess
from launch.frontend import Entity, Parser, expose_action, expose_substitution
from launch.substitution import Substitution


@expose_action("demo_server")
class DemoServer(Action):
    def __init__(self, *, world, plugins=(), **kwargs):
        super().__init__(**kwargs)
        self.world = world
        self.plugins = plugins

    @classmethod
    def parse(cls, entity: Entity, parser: Parser):
        _, kwargs = super().parse(entity, parser)
        kwargs["world"] = parser.parse_substitution(entity.get_attr("world"))
        plugins = entity.get_attr("plugin", data_type=List[Entity], optional=True)
        kwargs["plugins"] = [plugin.get_attr("name") for plugin in plugins or ()]
        return cls, kwargs


@expose_action("demo_tool")
class DemoTool(ExecuteProcess):
    @classmethod
    def parse(cls, entity, parser):
        _, kwargs = super().parse(entity, parser, ignore=["cmd"])
        kwargs["cmd"] = [["demo"], *cls._parse_cmdline(entity.get_attr("words"), parser)]
        return cls, kwargs


@expose_action("log_error")
class OwnLog(DemoServer):
    pass


@expose_substitution("demo-upper")
class Upper(Substitution):
    def __init__(self, text):
        self.text = text

    @classmethod
    def parse(cls, data):
        return cls, {"text": data[0]}
"""


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A package `demo_actions` whose entry point declares what it exposes."""
    (tmp_path / "demo_actions.py").write_text(PACKAGE)
    info = tmp_path / "demo_actions-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: demo-actions\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        f"[{expose.EXTENSION_GROUP}]\ndemo = demo_actions\nbroken = demo_no_such_module\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    actions = dict(frontend_registry.action_parse_methods)
    substitutions = dict(frontend_registry.substitution_parse_methods)
    with vocabulary():
        yield
    sys.modules.pop("demo_actions", None)
    for table, before in (
        (frontend_registry.action_parse_methods, actions),
        (frontend_registry.substitution_parse_methods, substitutions),
    ):
        table.clear()
        table.update(before)


def parse(text: str) -> Any:
    """The entities of an XML launch file."""
    entity, parser = XmlParser.load(StringIO(f"<launch>{text}</launch>"))
    return parser.parse_description(entity).entities


@pytest.mark.usefixtures("installed")
def test_tag_of_an_installed_package_is_found_by_its_entry_point() -> None:
    (server,) = parse('<demo_server world="w.sdf" if="true"><plugin name="p"/></demo_server>')
    assert (server.world[0].text, server.plugins) == ("w.sdf", ["p"])
    assert server.condition is not None


@pytest.mark.usefixtures("installed")
def test_subclass_of_a_process_reads_its_words_in_its_own_way() -> None:
    (tool,) = parse('<demo_tool words="a b" output="screen" name="n"/>')
    assert [[part.text for part in word] for word in tool.cmd] == [["demo"], ["a"], ["b"]]


@pytest.mark.usefixtures("installed")
def test_substitution_of_an_installed_package_is_found() -> None:
    (server,) = parse('<demo_server world="$(demo-upper abc)"/>')
    assert server.world[0].text[0].text == "abc"


@pytest.mark.usefixtures("installed")
def test_package_wins_over_a_name_that_came_after_jazzy() -> None:
    (own,) = parse('<log_error world="w"/>')
    assert type(own).__name__ == "OwnLog"


@pytest.mark.usefixtures("installed")
def test_attribute_that_the_package_does_not_know_is_refused() -> None:
    with pytest.raises(FrontendError, match="has no attribute 'wrold'"):
        parse('<demo_server world="w" wrold="x"/>')


@pytest.mark.usefixtures("installed")
def test_missing_attribute_of_a_package_is_reported_with_its_line() -> None:
    with pytest.raises(FrontendError, match="needs the attribute 'world'") as caught:
        parse("\n<demo_server/>")
    assert str(caught.value.where).endswith(":2")


def test_known_tags_do_not_look_for_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "importlib.metadata", raising=False)
    parse('<log message="$(var a b)"/>')
    assert "importlib.metadata" not in sys.modules


class Exposed:
    """Something with a parse method."""

    @classmethod
    def parse(cls, entity: Any, parser: Any) -> Any:
        """Nothing to read."""
        return cls, {}


@pytest.fixture
def table(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """An empty table of actions."""
    empty: dict[str, Any] = {}
    monkeypatch.setattr(frontend_registry, "action_parse_methods", empty)
    return empty


def test_class_or_function_can_be_exposed(table: dict[str, Any]) -> None:
    def parse_it(entity: Any, parser: Any) -> Any:
        return Exposed, {}

    assert frontend_registry.expose_action("one")(Exposed) is Exposed
    assert frontend_registry.expose_action("two")(parse_it) is parse_it
    assert table == {"one": Exposed.parse, "two": parse_it}


def test_two_parsers_of_one_name_are_refused(table: dict[str, Any]) -> None:
    class Other(Exposed):
        pass

    frontend_registry.expose_action("one")(Exposed)
    frontend_registry.expose_action("one")(Exposed)
    with pytest.raises(RuntimeError, match="same name"):
        frontend_registry.expose_action("one")(Other)


@pytest.mark.parametrize("exposed", [int, 5, None])
def test_only_what_can_parse_is_exposed(table: dict[str, Any], exposed: Any) -> None:
    with pytest.raises(RuntimeError):
        frontend_registry.expose_action("one")(exposed)
    assert table == {}
