"""Mutated launch files: they load, or end in a LauncherError. Nothing else."""

from __future__ import annotations

from io import StringIO

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from launcher.base.errors import LauncherError
from launcher.language.frontends.parser import Parser
from launcher.language.frontends.xml import XmlParser
from launcher.language.frontends.yaml import YamlParser
from tests.support.examples import examples

XML_SEED = """<?xml version="1.0"?>
<!DOCTYPE launch [<!ENTITY pkg "demo">]>
<launch>
  <arg name="a" default="$(var b 'c d')" description="x"><choice value="1"/></arg>
  <let name="k" value="$(eval '1 + $(var a)')" if="$(not true)"/>
  <!-- note --> <log message="\\$(x) $(env HOME '') $(dirname)"/>
  <group scoped="true"><keep name="n" value="v"/>
    <node pkg="&pkg;" exec="e" name="n" args="-a 'b c' $(var k)" respawn_delay="1.5" output="both">
      <param name="p" value="[1, 2]"/>
      <param name="g"><param name="h" value="1,2" value-sep=","/></param>
      <param from="f.yaml" allow_substs="true"/><remap from="a" to="b"/><env name="E" value="1"/>
    </node>
    <timer period="2.5" cancel_on_shutdown="false"><shutdown reason="over"/></timer>
  </group>
  <include file="$(find-pkg-share p)/x.xml"><arg name="n" value="v"/></include>
  <executable cmd="ls -l" shell="true" emulate_tty="yes" on_exit="shutdown"/>
</launch>
"""

YAML_SEED = """launch:
  - arg: {name: a, default: "$(var b 'c d')", choice: [{value: "1"}]}
  - let: &let {name: k, value: "$(eval '1 + $(var a)')", if: "$(not true)"}
  - log: {message: "$(env HOME '') $(dirname)"}
  - group:
      scoped: true
      keep: [{name: n, value: v}]
      children:
        - node:
            pkg: demo
            exec: e
            args: -a 'b c' $(var k)
            respawn_delay: 1.5
            param:
              - {name: p, value: [1, 2]}
              - {name: g, param: [{name: h, value: 2.5}]}
              - {from: f.yaml, allow_substs: true}
            remap: [{from: a, to: b}]
        - timer: {period: 2.5, children: [{shutdown: {reason: over}}]}
  - include: {file: x.yaml, arg: [{name: n, value: v}]}
  - executable: {cmd: "ls -l", shell: true, env: [{name: E, value: "1"}]}
  - let: *let
"""

TOKENS = st.sampled_from(
    [
        *"<>/&;\"'$()[]{}:,-|>!*%#\\\n\t \x00",
        "$(", "$(var ", "')", "if=\"true\"", "<node>", "</node>", "<group>", "&pkg;", "&#0;",
        "  - ", "launch:", "null", "true", "1e999", "!!python/x ", "<<: *let", "*let", "&x ",
        "---\n",
        "<!--", "-->", "<![CDATA[", "\ud800", "\u0085", "1:2:3", "0o9", "2001-99-99", "children: ",
    ]
)  # fmt: skip


@st.composite
def mutated(draw: st.DrawFn, seed: str) -> str:
    """The seed with a few pieces cut out, repeated or put in."""
    text = seed
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, 30)))
        piece = draw(st.sampled_from(["", text[start:end] * 2]) | TOKENS)
        text = text[:start] + piece + text[end:]
    return text


@settings(max_examples=examples(250), suppress_health_check=list(HealthCheck))
@given(mutated(XML_SEED))
def test_mutated_xml_loads_or_ends_in_a_launcher_error(text: str) -> None:
    load_or_refuse(XmlParser, text)


@settings(max_examples=examples(250), suppress_health_check=list(HealthCheck))
@given(mutated(YAML_SEED))
def test_mutated_yaml_loads_or_ends_in_a_launcher_error(text: str) -> None:
    load_or_refuse(YamlParser, text)


@settings(max_examples=examples(100))
@given(st.text(max_size=60))
def test_any_text_ends_in_a_launcher_error(text: str) -> None:
    load_or_refuse(Parser, text)


@pytest.mark.parametrize(("parser", "seed"), [(XmlParser, XML_SEED), (YamlParser, YAML_SEED)])
def test_seed_itself_loads(parser: type[Parser], seed: str) -> None:
    assert load_or_refuse(parser, seed)


def load_or_refuse(parser_type: type[Parser], text: str) -> bool:
    """Load a text; whether it was one. The error can be printed, and knows how long it is."""
    try:
        entity, parser = parser_type.load(StringIO(text))
        parser.parse_description(entity)
    except LauncherError as error:
        assert error.render().startswith("error: ")
        assert error.column is None or error.column > 0
        return False
    return True
