"""Values of conditions and arguments that a launch file cannot use."""

from __future__ import annotations

from tests.launch.unit.classic_mistakes.cases import Case, described, python

NEITHER = "invalid condition expression, expected one of [true, 1, false, 0] but got '{}'"

ERRORS = {
    "a condition": python(
        described("LogInfo(msg='x', condition=IfCondition(LaunchConfiguration('d'))),"),
        "d')",
        NEITHER.format("flase"),
        "d is 'flase', on the command line; did you mean d:=false?",
        words=("d:=flase",),
    ),
    "a condition whose value was set in the file": python(
        """
        def generate_launch_description():
            return LaunchDescription([
                SetLaunchConfiguration('a', 'yes'),
                LogInfo(msg='x', condition=UnlessCondition(LaunchConfiguration('a')))])  # here
        """,
        "a')",
        NEITHER.format("yes"),
        "a is 'yes', set at FILE:10; did you mean 'true'?",
    ),
    "a condition on several values": python(
        described("LogInfo(msg='x', condition=IfCondition([LaunchConfiguration('d'), 'x'])),"),
        "d'), 'x'",
        NEITHER.format("/tmpx"),
        "d is '/tmp', default at FILE:10",
    ),
    "a negation": python(
        described(
            "LogInfo(msg='x', condition=IfCondition(NotSubstitution(LaunchConfiguration('d')))),"
        ),
        "d')",
        "Cannot convert value 'ture' to '<class 'bool'>'",
        "d is 'ture', on the command line; did you mean d:=true?",
        words=("d:=ture",),
    ),
    "a value outside of choices": python(
        described("DeclareLaunchArgument('mode', default_value='a', choices=['a', 'false']),"),
        "mode'",
        "argument 'mode' cannot be 'no'",
        "did you mean mode:=false?",
        words=("mode:=no",),
    ),
    "a condition in XML": Case(
        '<launch>\n  <arg name="x" default="1"/>\n  <log message="a"\n       if="$(var x)"/>\n'
        "</launch>\n",
        4,
        "x)",
        NEITHER.format("flase"),
        "x is 'flase', on the command line; did you mean x:=false?",
        suffix="xml",
        words=("x:=flase",),
    ),
    "a condition in YAML": Case(
        "launch:\n- arg:\n    name: x\n- log:\n    message: a\n    unless: $(var x)\n",
        6,
        "x)",
        NEITHER.format("flase"),
        "x is 'flase', on the command line; did you mean x:=false?",
        suffix="yaml",
        words=("x:=flase",),
    ),
}
