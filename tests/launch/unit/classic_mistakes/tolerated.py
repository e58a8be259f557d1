"""Mistakes that ROS 2 runs nevertheless: each gets a warning, without a caret."""

from __future__ import annotations

from tests.launch.unit.classic_mistakes.cases import Case, described, python

WARNINGS = {
    "an f-string": python(
        described("LogInfo(msg=f\"in {LaunchConfiguration('d')}\"),"),
        "",
        "a LaunchConfiguration is used as text, which gives "
        "'<launch.substitutions.launch_configuration.LaunchConfiguration object ...>'",
        "write ['in ', LaunchConfiguration('d')]",
    ),
    "str()": python(
        described("LogInfo(msg=str(LaunchConfiguration('d'))),"),
        "",
        "a LaunchConfiguration is used as text, which gives "
        "'<launch.substitutions.launch_configuration.LaunchConfiguration object ...>'",
        "write a list, as in ['text', LaunchConfiguration('d')]",
    ),
    "a comparison": python(
        """
        def generate_launch_description():
            mode = LaunchConfiguration('mode')
            if mode == 'fast':  # here
                return LaunchDescription([])
            return LaunchDescription([DeclareLaunchArgument('mode', default_value='fast')])
        """,
        "",
        "a LaunchConfiguration is compared with a text, and is never equal to it",
        "write condition=IfCondition(EqualsSubstitution(LaunchConfiguration('mode'), 'fast'))",
    ),
    "a command of one word": python(
        described("ExecuteProcess(cmd=['ls -la', '/tmp']),"),
        "",
        "'ls -la' is one word, and there is no program of this name",
        "write cmd=['ls', '-la', '/tmp'], or add shell=True",
    ),
    "a shell command of one word": python(
        described("ExecuteProcess(cmd=['ls | wc']),"),
        "",
        "'ls | wc' is one word, and there is no program of this name",
        "add shell=True",
    ),
    "an executable with arguments": python(
        described("Node(executable='ls -la'),"),
        "",
        "'ls -la' is one word, and there is no program of this name",
        "write executable='ls', and the rest in arguments=['-la']",
    ),
    "a command as a text": python(
        described("ExecuteProcess(cmd='ls -la'),"),
        "",
        "cmd is a text, of which each letter becomes a word",
        "write cmd=['ls', '-la']",
    ),
    "arguments as a text": python(
        described("Node(executable='ls', arguments='-l -a'),"),
        "",
        "arguments is a text, of which each letter becomes a word",
        "write arguments=['-l', '-a']",
    ),
    "a function without return": python(
        """
        def setup(context):
            actions = []
            actions.append(ExecuteProcess(cmd=['ls']))  # here
        def generate_launch_description():
            return LaunchDescription([OpaqueFunction(function=setup)])
        """,
        "",
        "setup() returns nothing, so its ExecuteProcess is not run",
        "return a list of the actions at its end",
    ),
    "an entity without visit": python(
        """
        class Mine(LaunchDescriptionEntity):
            def visti(self, context):  # here
                return [LogInfo(msg='x')]
        def generate_launch_description():
            return LaunchDescription([Mine()])
        """,
        "",
        "Mine does nothing, since it has no method visit()",
        "write 'def visit(self, context)' instead of 'def visti'",
    ),
    "an action without execute": python(
        """
        class Mine(Action):
            def excute(self, context):  # here
                return [LogInfo(msg='x')]
        def generate_launch_description():
            return LaunchDescription([Mine()])
        """,
        "",
        "Mine does nothing, since it has no method execute()",
        "write 'def execute(self, context)' instead of 'def excute'",
    ),
    "a condition without evaluate": python(
        """
        class Mine(Condition):
            def evalute(self, context):  # here
                return True
        def generate_launch_description():
            return LaunchDescription([LogInfo(msg='x', condition=Mine())])
        """,
        "",
        "Mine is always false, since it has no method evaluate()",
        "write 'def evaluate(self, context)' instead of 'def evalute'",
    ),
    "a misspelt argument of an include": python(
        """
        def generate_launch_description():
            return LaunchDescription([
                IncludeLaunchDescription(
                    os.path.join(os.path.dirname(__file__), 'child.launch.xml'),
                    launch_arguments={
                        'cuont': '3'}.items())])  # here
        """,
        "",
        "child.launch.xml does not declare the argument 'cuont', which is ignored",
        "did you mean 'count'?",
    ),
    "an unknown argument of an include": Case(
        '<launch>\n  <include file="$(dirname)/child.launch.xml">\n'
        '    <arg name="colour" value="3"/>\n  </include>\n</launch>\n',
        3,
        "",
        "child.launch.xml does not declare the argument 'colour', which is ignored",
        "it declares: count",
        suffix="xml",
    ),
    "a misspelt argument of an include in YAML": Case(
        "launch:\n- include:\n    file: $(dirname)/child.launch.xml\n    arg:\n"
        "    - name: cuont\n      value: '3'\n",
        5,
        "",
        "child.launch.xml does not declare the argument 'cuont', which is ignored",
        "did you mean 'count'?",
        suffix="yaml",
    ),
}
