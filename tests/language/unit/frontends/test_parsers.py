"""The constructor arguments of actions that XML tags and YAML keys become."""

from __future__ import annotations

import re
from io import StringIO
from typing import Any

import pytest

from launcher.language.frontends import expose
from launcher.language.frontends.errors import FrontendError
from launcher.language.frontends.parser import MAX_PROBLEMS, Parser
from launcher.language.frontends.parsers.process import parse_words
from launcher.language.frontends.xml import XmlParser
from launcher.language.frontends.yaml import YamlParser
from launcher.language.substitution import Substitution


def arguments_of(text: str) -> tuple[str, dict[str, Any]]:
    """(class name, constructor arguments in readable form) of the first action of a text."""
    loader: type[Parser] = XmlParser if text.startswith("<") else YamlParser
    wrapped = f"<launch>{text}</launch>" if loader is XmlParser else f"launch: [{text}]"
    root, parser = loader.load(StringIO(wrapped))
    entity = root.children[0]
    method = expose.action_parser(entity.type_name)
    assert method is not None
    action_type, arguments = method(entity, parser)
    entity.assert_entity_completely_parsed()
    return action_type.__name__, {key: readable(value) for key, value in arguments.items()}


def readable(value: Any) -> Any:
    """Substitutions by their description, containers item by item."""
    if isinstance(value, Substitution):
        return value.describe()
    if isinstance(value, dict):
        return {readable(key): readable(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        items = [readable(item) for item in value]
        return "+".join(items) if value and _all_substitutions(value) else items
    if isinstance(value, (str, int, float, bool, type(None))):
        return value
    return type(value).__name__


def _all_substitutions(items: Any) -> bool:
    return all(isinstance(item, Substitution) for item in items)


NAME_VALUE = {"name": "'n'", "value": "'v'"}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    '<arg name="a\\$" default="$(var b)x" description="d" if="1"><choice value="c"/></arg>': (
        "DeclareLaunchArgument",
        {
            "condition": "IfCondition",
            "name": "a$",
            "default_value": "LaunchConfig('b')+'x'",
            "description": "d",
            "choices": ["c"],
        },
    ),
    "arg: {name: a}": ("DeclareLaunchArgument", {"name": "a"}),
    '<let name="n" value="v" unless="0"/>': (
        "SetLaunchConfiguration",
        {"condition": "UnlessCondition", **NAME_VALUE},
    ),
    "let: {name: n, value: v}": ("SetLaunchConfiguration", NAME_VALUE),
    '<unset name="n"/>': ("UnsetLaunchConfiguration", {"name": "'n'"}),
    '<bool_arg name="a" default="true"/>': (
        "DeclareBooleanLaunchArgument",
        {"name": "a", "default_value": "'true'"},
    ),
    '<set_env name="n" value="v"/>': ("SetEnvironmentVariable", NAME_VALUE),
    '<append_env name="n" value="v" prepend="yes" separator=";"/>': (
        "AppendEnvironmentVariable",
        {**NAME_VALUE, "prepend": True, "separator": "';'"},
    ),
    "append_env: {name: n, value: v, prepend: $(var p)}": (
        "AppendEnvironmentVariable",
        {**NAME_VALUE, "prepend": "LaunchConfig('p')"},
    ),
    '<unset_env name="n"/>': ("UnsetEnvironmentVariable", {"name": "'n'"}),
    "reset_env: {}": ("ResetEnvironment", {}),
    '<log message="$(var a) b"/>': ("LogInfo", {"msg": "LaunchConfig('a')+' b'"}),
    '<log message="m" level="warning"/>': ("Log", {"msg": "'m'", "level": "'warning'"}),
    '<log_info message="m"/>': ("LogInfo", {"msg": "'m'"}),
    '<log_debug message="m"/>': ("LogDebug", {"msg": "'m'"}),
    "log_warning: {message: m}": ("LogWarning", {"msg": "'m'"}),
    "log_error: {message: m}": ("LogError", {"msg": "'m'"}),
    '<rep_env><env name="n" value="v"/></rep_env>': (
        "ReplaceEnvironmentVariables",
        {"environment": {"'n'": "'v'"}},
    ),
    '<for len="$(var n)" name="i"><log message="$(index i)"/></for>': (
        "ForLoop",
        {"length": "LaunchConfig('n')", "name": "i", "function": "function"},
    ),
    '<for_each values="{a: 1}"><log message="$(for-var a)"/></for_each>': (
        "ForEach",
        {"input_values": "'{a: 1}'", "function": "function"},
    ),
    '<shutdown reason="r"/>': ("Shutdown", {"reason": "r"}),
    '<shutdown reason="$(var r)"/>': ("Shutdown", {"reason": "LaunchConfig('r')"}),
    "<shutdown/>": ("Shutdown", {}),
    '<group scoped="no" forwarding="false"><keep name="n" value="v"/><log message="m"/></group>': (
        "GroupAction",
        {
            "scoped": False,
            "forwarding": False,
            "launch_configurations": {"'n'": "'v'"},
            "actions": ["LogInfo"],
        },
    ),
    "group: [{log: {message: m}}]": ("GroupAction", {"actions": ["LogInfo"]}),
    "reset: {keep: [{name: n, value: v}]}": (
        "ResetLaunchConfigurations",
        {"launch_configurations": {"'n'": "'v'"}},
    ),
    '<timer period="2" cancel_on_shutdown="0"><shutdown/></timer>': (
        "TimerAction",
        {"period": 2.0, "actions": ["Shutdown"], "cancel_on_shutdown": False},
    ),
    '<trace session-name="s" events-kernel="" if="1"/>': ("Trace", {"condition": "IfCondition"}),
    '<timer period="$(var p)"/>': ("TimerAction", {"period": "LaunchConfig('p')", "actions": []}),
    '<include file="f"><let name="n" value="l"/><arg name="n" value="v"/></include>': (
        "IncludeLaunchDescription",
        {"launch_description_source": "'f'", "launch_arguments": [["'n'", "'v'"], ["'n'", "'l'"]]},
    ),
    '<executable cmd="ls $(var d)/x" cwd="/" name="l" shell="1" emulate_tty="perhaps" '
    'launch-prefix="nice" output="$(var o)" respawn="yes" respawn_max_retries="many" '
    'respawn_delay="1.5" sigterm_timeout="2" on_exit="shutdown"><env name="n" value="v"/>'
    "</executable>": (
        "ExecuteProcess",
        {
            "cmd": ["'ls'", "LaunchConfig('d')+'/x'"],
            "cwd": "'/'",
            "name": "'l'",
            "shell": True,
            "emulate_tty": "perhaps",
            "prefix": "'nice'",
            "output": "LaunchConfig('o')",
            "respawn": "'yes'",
            "respawn_max_retries": "many",
            "respawn_delay": 1.5,
            "sigterm_timeout": "2.0",
            "on_exit": ["Shutdown"],
            "additional_env": {"'n'": "'v'"},
        },
    ),
    '<node pkg="p" exec="e" name="n" namespace="s" exec_name="l" args="-a b" ros_args="--x">'
    '<remap from="a" to="b"/><param name="i" value="1"/><param from="f"/></node>': (
        "Node",
        {
            "arguments": ["'-a'", "'b'"],
            "ros_arguments": ["'--x'"],
            "name": "'n'",
            "exec_name": "'l'",
            "package": "'p'",
            "executable": "'e'",
            "namespace": "'s'",
            "remappings": [["'a'", "'b'"]],
            "parameters": [{"'i'": "ParameterValue"}, "ParameterFile"],
        },
    ),
    '<lifecycle_node pkg="p" exec="e" name="n" namespace="" autostart="1"/>': (
        "LifecycleNode",
        {"name": "'n'", "package": "'p'", "executable": "'e'", "namespace": "''"}
        | {"autostart": True},
    ),
    '<lifecycle_node pkg="p" exec="e" name="n" namespace="" autostart="$(var a)"/>': (
        "LifecycleNode",
        {"name": "'n'", "package": "'p'", "executable": "'e'", "namespace": "''"}
        | {"autostart": "LaunchConfig('a')"},
    ),
    "node: {pkg: p, exec: e, param: [{name: g, param: [{name: x, value: 1}]}]}": (
        "Node",
        {
            "package": "'p'",
            "executable": "'e'",
            "parameters": [{"'g'": {"'x'": "ParameterValue"}}],
        },
    ),
    '<node_container pkg="p" exec="e" name="n" namespace=""><composable_node pkg="q" plugin="c"/>'
    "</node_container>": (
        "ComposableNodeContainer",
        {
            "name": "'n'",
            "package": "'p'",
            "executable": "'e'",
            "namespace": "''",
            "composable_node_descriptions": ["ComposableNode"],
        },
    ),
    '<load_composable_node target="t"><composable_node pkg="q" plugin="c" name="n" if="1">'
    '<param name="a" value="1"/><remap from="a" to="b"/><extra_arg name="n" value="v"/>'
    "</composable_node></load_composable_node>": (
        "LoadComposableNodes",
        {"target_container": "'t'", "composable_node_descriptions": ["ComposableNode"]},
    ),
    '<load_composable_node target="t">'
    '<composable_lifecycle_node pkg="q" plugin="c" name="n" autostart="true"/>'
    '<composable_node pkg="q" plugin="c" name="n"/></load_composable_node>': (
        "LoadComposableNodes",
        {"target_container": "'t'"}
        | {"composable_node_descriptions": ["ComposableNode", "ComposableLifecycleNode"]},
    ),
    '<push-ros-namespace namespace="n"/>': ("PushROSNamespace", {"namespace": "'n'"}),
    "push_ros_namespace: {namespace: n}": ("PushROSNamespace", {"namespace": "'n'"}),
    '<set_parameter name="n" value="v"/>': ("SetParameter", NAME_VALUE),
    '<set_remap from="a" to="b"/>': ("SetRemap", {"src": "'a'", "dst": "'b'"}),
    '<set_parameters_from_file filename="f"/>': ("SetParametersFromFile", {"filename": "'f'"}),
    '<set_ros_log_dir new_log_dir="d"/>': ("SetROSLogDir", {"new_log_dir": "'d'"}),
    '<set_use_sim_time value="true"/>': ("SetUseSimTime", {"value": True}),
    "set_use_sim_time: {value: $(var sim)}": ("SetUseSimTime", {"value": "LaunchConfig('sim')"}),
    "ros_timer: {period: 1.5, children: []}": ("RosTimer", {"period": 1.5, "actions": []}),
}


@pytest.mark.parametrize("text", CASES)
def test_tag_becomes_an_action(text: str) -> None:
    assert arguments_of(text) == CASES[text]


def test_every_tag_is_tested() -> None:
    tested = {re.match(r"<?([\w-]+)", text)[1] for text in CASES}  # type: ignore[index]
    assert tested == set(expose.tables.ACTIONS)


REFUSED = {
    '<log message="m" if="1" unless="0"/>': "cannot be used together",
    '<node pkg="p"/>': "needs the attribute 'exec'",
    '<node pkg="p" exec="e" node-name="n"/>': "no longer takes 'node-name'",
    '<node pkg="p" exec="e" type="t"/>': "has no attribute 'type'",
    '<node pkg="p" exec="e"><env name="n" vlaue="v"/></node>': "needs the attribute 'value'",
    '<node pkg="p" exec="e"><param/></node>': "needs a 'name'",
    '<node pkg="p" exec="e"><param name="n"/></node>': "needs a 'value'",
    '<node pkg="p" exec="e"><param name="n" from="f"/></node>': "exclude each other",
    '<node pkg="p" exec="e"><param name="n" value="1" allow_substs="1"/></node>': "allow_substs",
    '<node pkg="p" exec="e"><param name="n" value="1" type="flaot"/></node>': (
        "unknown type 'flaot'"
    ),
    '<node pkg="p" exec="e"><param name="n" value="1"><param name="m" value="2"/></param></node>': (
        "cannot have a 'value'"
    ),
    '<node pkg="p" exec="e"><param name="n" value="1|x" value-sep="|"/></node>': "non-uniform",
    '<node pkg="p" exec="e"><param name="n" value="1" unit="m"/></node>': "no attribute 'unit'",
    '<node pkg="p" exec="e" respawn_delay="$(var d)"/>': "number of seconds",
    '<node pkg="p" exec="e" respawn_delay="-1"/>': "negative",
    '<node pkg="p" exec="e" on_exit="restart"/>': "can only be 'shutdown'",
    "<executable cmd=\"ls '$(var a)'\"/>": "No closing quotation",
    '<include file="f"><set name="n" value="v"/></include>': "is not allowed inside <include>",
    '<arg name="n" value="v"/>': "has no attribute 'value'",
    '<bool_arg name="n"><choice value="c"/></bool_arg>': "Cannot specify choices for bool_arg",
    '<load_composable_node target="t"/>': "needs a nested tag <composable_node> or",
    '<load_composable_node target="t"><composable_node pkg="q" plugin="c" autostart="1"/>'
    "</load_composable_node>": "has no attribute 'autostart'",
    '<lifecycle_node pkg="p" exec="e" name="n" namespace="" autostart="maybe"/>': (
        "'autostart' should be true, false or a substitution, not 'maybe'"
    ),
    '<set_use_sim_time value="maybe"/>': "'value' should be true, false or a substitution",
    '<log message="$(find p)"/>': "unknown substitution",
    '<log message="$(env)"/>': r"has 0 words \(env substitution expects 1 or 2 arguments\)",
    '<log message="$(var a"/>': "expected '\\)'",
    '<param name="n" value="1"/>': "unknown action 'param'",
    "log: {message: 5}": "should be of type str",
    "node: {pkg: p, exec: e, respawn: true}": "should be of type str",
    "node: {pkg: p, exec: e, param: {rate: 5}}": "list of mappings",
    "reset_env: null": "takes attributes",
    "log: text": "takes attributes",
}


@pytest.mark.parametrize("text", REFUSED)
def test_mistake_is_reported_with_its_line(text: str) -> None:
    loader: type[Parser] = XmlParser if text.startswith("<") else YamlParser
    wrapped = (
        f"<launch>\n{text}\n</launch>" if loader is XmlParser else f"launch:\n  - {{{text}}}\n"
    )
    root, parser = loader.load(StringIO(wrapped))
    with pytest.raises(FrontendError, match=REFUSED[text]) as caught:
        parser.parse_description(root)
    assert str(caught.value.where).endswith(":2")
    assert caught.value.source_line == wrapped.splitlines()[1]


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("launch: [arg: {name: a, choices: [b, c]}]", "'choice' takes a list"),
        ("launch: [include: f.launch.yaml]", "write 'include: {file: f.launch.yaml}'"),
        ('<launch><log message="$(eq a b)"/></launch>', "did you mean 'equals'?"),
        ('<launch><for_each iter="x"/></launch>', "ROS 2 uses 'values' instead of 'iter'"),
        ("launch: [log: text]", "write 'log: {message: text}'"),
        (
            '<launch><node pkg="p" exec="e"><param name="n" value="1" if="0"/></node></launch>',
            "$(if ",
        ),
    ],
)
def test_what_ros_2_writes_differently_is_refused_with_what_to_write(text: str, hint: str) -> None:
    root, parser = Parser.load(StringIO(text))
    with pytest.raises(FrontendError) as caught:
        parser.parse_description(root)
    assert hint in (caught.value.hint or "")


def test_all_independent_mistakes_are_reported_at_once() -> None:
    text = '<launch>\n<nod/>\n<group>\n<lgo/>\n<log/>\n</group>\n<log message="m"/>\n</launch>'
    root, parser = XmlParser.load(StringIO(text))
    with pytest.raises(FrontendError) as caught:
        parser.parse_description(root)
    lines = [line for line in caught.value.render().splitlines() if line.startswith("error")]
    assert [line.split(":")[2] for line in lines] == ["2", "4", "5"]


def test_number_of_reported_mistakes_is_bounded() -> None:
    root, parser = XmlParser.load(
        StringIO("<launch>" + "<group><lgo/><nod/></group>" * 500 + "</launch>")
    )
    with pytest.raises(FrontendError) as caught:
        parser.parse_description(root)
    assert len(caught.value.others) + 1 == MAX_PROBLEMS


def test_caret_is_under_the_wrong_character() -> None:
    text = '<launch>\n  <log\n    message="$(var a)$(find b)"/>\n</launch>'
    root, parser = XmlParser.load(StringIO(text))
    with pytest.raises(FrontendError) as caught:
        parser.parse_description(root)
    assert str(caught.value.where).endswith(":3")
    assert caught.value.source_line is not None and caught.value.column is not None
    assert caught.value.source_line[caught.value.column - 1 :].startswith("$(find b)")


def test_actions_know_their_line() -> None:
    root, parser = XmlParser.load(StringIO('<launch>\n\n<log message="$(var a)"/></launch>'))
    (log,) = parser.parse_description(root).entities
    assert log._origin is not None and log._origin.line == 3


SUBSTITUTIONS = {
    "$(and true false)": "AndSubstitution",
    "$(anon n)": "AnonName",
    "$(command 'ls -l' ignore)": "Command",
    "$(dirname)": "ThisLaunchFileDir",
    "$(env N d)": "EnvironmentVariable",
    "$(equals a b)": "EqualsSubstitution",
    "$(eval '1 + 1')": "PythonExpression",
    "$(eval 'math.pi' 'math, os')": "PythonExpression",
    "$(eval '1' '')": "PythonExpression",
    "$(exec-in-pkg e p)": "ExecutableInPackage",
    "$(file-content f)": "FileContent",
    "$(filename)": "ThisLaunchFile",
    "$(find-exec e)": "FindExecutable",
    "$(find-pkg-prefix p)": "FindPackagePrefix",
    "$(find-pkg-share p)": "FindPackageShare",
    "$(if true a b)": "IfElseSubstitution",
    "$(for-var a b)": "ForEachVar",
    "$(index i)": "ForLoopIndex",
    "$(path-join a$(var b) 'c d')": "PathJoinSubstitution",
    "$(string-join . a b$(var c))": "StringJoinSubstitution",
    "$(launch_log_dir)": "LaunchLogDir",
    "$(log_dir)": "LaunchLogDir",
    "$(not true)": "NotSubstitution",
    "$(not-equals a b)": "NotEqualsSubstitution",
    "$(or true false)": "OrSubstitution",
    "$(param p)": "Parameter",
    "$(any)": "AnySubstitution",
    "$(all 1 'true' $(var a))": "AllSubstitution",
    "$(var v d)": "LaunchConfiguration",
}


@pytest.mark.parametrize("text", SUBSTITUTIONS)
def test_substitution_is_made(text: str) -> None:
    (made,) = Parser().parse_substitution(text)
    assert type(made).__name__ == SUBSTITUTIONS[text]


def test_every_substitution_is_tested() -> None:
    tested = {text[2:].rstrip(")").split()[0] for text in SUBSTITUTIONS}
    assert set(expose.tables.SUBSTITUTIONS) == tested


@pytest.mark.parametrize(
    "text", ["$(dirname x)", "$(env)", "$(env a b c)", "$(if true)", "$(var)", "$(not a b)"]
)
def test_wrong_number_of_words_is_reported_with_the_right_one(text: str) -> None:
    with pytest.raises(FrontendError, match=r"has \d words") as caught:
        Parser().parse_substitution(text)
    assert caught.value.hint is not None and caught.value.hint.startswith("usage: $(")
    assert caught.value.ros_type == "VisitError"


WORDS = {
    "$(var a)/b c d $(var e)/f": ["LaunchConfig('a')+'/b'", "'c'", "'d'", "LaunchConfig('e')+'/f'"],
    "$(var a) x/$(var b) ": ["LaunchConfig('a')", "'x/'+LaunchConfig('b')"],
    "$(var a)$(var b)": ["LaunchConfig('a')+LaunchConfig('b')"],
    "$(var a) $(var b)": ["LaunchConfig('a')", "LaunchConfig('b')"],
    "a 'b c' \"d e\"": ["'a'", "'b c'", "'d e'"],
    "a ": ["'a'"],
    " a": ["'a'"],
    "": [[]],
    "  ": [[]],
    "''": ["''"],
}


@pytest.mark.parametrize("text", WORDS)
def test_command_line_is_split_as_ros_splits_it(text: str) -> None:
    assert readable(parse_words(object, text, Parser())) == WORDS[text]
