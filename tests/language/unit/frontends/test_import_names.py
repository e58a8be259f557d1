"""The import names `launch.frontend`, `launch_xml` and `launch_yaml`."""

from __future__ import annotations

import importlib

import pytest

from launcher.language.compat import vocabulary

NAMES = {
    "launch.frontend": "Entity Parser expose_action expose_substitution parse_substitution "
    "InvalidFrontendLaunchFileError",
    "launch.frontend.entity": "Entity",
    "launch.frontend.expose": "expose_action expose_substitution instantiate_action "
    "instantiate_substitution action_parse_methods substitution_parse_methods",
    "launch.frontend.parse_substitution": "parse_substitution parse_if_substitutions "
    "replace_escaped_characters",
    "launch.frontend.parser": "Parser InvalidFrontendLaunchFileError",
    "launch.frontend.type_utils": "check_is_list_entity get_data_type_from_identifier",
    "launch_xml": "Entity Parser",
    "launch_xml.launch_description_sources": "XMLLaunchDescriptionSource",
    "launch_yaml": "Entity Parser",
    "launch_yaml.launch_description_sources": "YAMLLaunchDescriptionSource",
}


@pytest.mark.parametrize("module", NAMES)
def test_names_can_be_imported(module: str) -> None:
    with vocabulary():
        found = importlib.import_module(module)
        missing = [name for name in NAMES[module].split() if not hasattr(found, name)]
    assert missing == []


def test_parse_substitution_is_the_function_although_a_module_has_its_name() -> None:
    with vocabulary():
        importlib.import_module("launch.frontend.parse_substitution")
        function = importlib.import_module("launch.frontend").parse_substitution
        (made,) = function("$(var x)")
    assert type(made).__name__ == "LaunchConfiguration"


def test_known_suffixes_are_listed() -> None:
    with vocabulary():
        parser = importlib.import_module("launch.frontend").Parser
        assert {"xml", "yaml"} <= set(parser.get_available_extensions())
        assert parser.is_extension_valid("xml")
        assert not parser.is_extension_valid("nope")
        with pytest.raises(RuntimeError):
            parser.get_parser_from_extension("nope")
