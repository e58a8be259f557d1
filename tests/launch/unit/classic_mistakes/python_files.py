"""Mistakes in what a launch file in Python calls, passes, imports and returns."""

from __future__ import annotations

from tests.launch.unit.classic_mistakes.cases import described, python

NO_TEXT = "a LaunchConfiguration is not a text: it gets its value only when the launch file is run"
IN_A_FUNCTION = "in the function of an OpaqueFunction"

ERRORS = {
    # ---- substitutions as texts
    "os.path.join": python(
        described("LogInfo(msg=os.path.join(LaunchConfiguration('d'), 'x.yaml'))"),
        "LaunchConfiguration(",
        NO_TEXT,
        "write PathJoinSubstitution([LaunchConfiguration('d'), 'x.yaml'])",
    ),
    "a sum": python(
        described("LogInfo(msg=LaunchConfiguration('d') + '/x' + '.yaml')"),
        "LaunchConfiguration(",
        NO_TEXT,
        "write [LaunchConfiguration('d'), '/x', '.yaml']",
    ),
    "a sum that begins with a text": python(
        described("LogInfo(msg='in ' + LaunchConfiguration('d'))"),
        "LaunchConfiguration(",
        NO_TEXT,
        "write ['in ', LaunchConfiguration('d')]",
    ),
    "a quotient": python(
        described("LogInfo(msg=LaunchConfiguration('d') / 'x.yaml')"),
        "LaunchConfiguration(",
        NO_TEXT,
        "write PathJoinSubstitution([LaunchConfiguration('d'), 'x.yaml'])",
    ),
    "open": python(
        """
        def generate_launch_description():
            config = LaunchConfiguration('config')
            with open(config) as file:  # here
                return LaunchDescription([LogInfo(msg=file.read())])
        """,
        "with open",
        NO_TEXT,
        f"write config.perform(context) {IN_A_FUNCTION}",
    ),
    "a number": python(
        described("LogInfo(msg=str(int(LaunchConfiguration('d'))))"),
        "LaunchConfiguration(",
        NO_TEXT,
        f"write LaunchConfiguration('d').perform(context) {IN_A_FUNCTION}",
    ),
    "a method of texts": python(
        described("LogInfo(msg=LaunchConfiguration('d').split('/'))"),
        "split(",
        "a LaunchConfiguration is not a text and has no method split(): "
        "it gets its value only when the launch file is run",
        f"write LaunchConfiguration('d').perform(context) {IN_A_FUNCTION}",
    ),
    "a misspelt method": python(
        described("OpaqueFunction(function=lambda c: LaunchConfiguration('d').preform(c))"),
        "preform(",
        "a LaunchConfiguration has no attribute 'preform'",
        "did you mean 'perform'?",
    ),
    # ---- values of a wrong type
    "parameters as a dictionary": python(
        """
        def generate_launch_description():
            return LaunchDescription([
                Node(package='p',
                     executable='x',
                     parameters={'a': 1})])  # here
        """,
        "parameters=",
        "parameters of Node takes a list, not a dict",
        "write parameters=[{'a': 1}]",
    ),
    "parameters as a path": python(
        described("Node(package='p', executable='x', parameters='a.yaml'),"),
        "parameters=",
        "parameters of Node takes a list, not a str",
        "write parameters=['a.yaml']",
    ),
    "remappings as a pair": python(
        described("Node(package='p', executable='x', remappings=('a', 'b')),"),
        "remappings=",
        "each entry of remappings is a pair of names in parentheses, not a str",
        "write remappings=[('a', 'b')]",
    ),
    "remappings of three names": python(
        described("Node(package='p', executable='x', remappings=[('a', 'b', 'c')]),"),
        "remappings=",
        "each entry of remappings is a pair of names",
        "write remappings=[('from', 'to')]",
    ),
    "an int as period": python(
        described("TimerAction(period=3, actions=[]),"),
        "period=3",
        "period of TimerAction takes a float, a text or a Substitution, not an int",
        "write period=3.0",
    ),
    "a single action of a timer": python(
        described("TimerAction(period=3.0, actions=LogInfo(msg='x')),"),
        "actions=",
        "actions of TimerAction takes a list, not a LogInfo",
        "write actions=[LogInfo(msg='x')]",
    ),
    "a single action of a description": python(
        """
        def generate_launch_description():
            return LaunchDescription(Node(package='p', executable='x'))  # here
        """,
        "Node(",
        "LaunchDescription takes a list of actions, not a single Node",
        "write LaunchDescription([Node(...)])",
    ),
    "a single action of a group": python(
        described("GroupAction(LogInfo(msg='x')),"),
        "LogInfo(",
        "GroupAction takes a list of actions, not a single LogInfo",
        "write GroupAction([LogInfo(...)])",
    ),
    "a list in a list": python(
        """
        def generate_launch_description():
            nodes = [Node(package='p', executable='x')]
            return LaunchDescription([
                LogInfo(msg='x'),
                nodes,  # here
            ])
        """,
        "nodes,",
        "entry 2 of 2 in LaunchDescription([...]) is not an action: a list of actions",
        "unpack it: write *nodes",
    ),
    "a literal list in a list": python(
        """
        def generate_launch_description():
            return LaunchDescription([[LogInfo(msg='x')]])  # here
        """,
        "return",
        "entry 1 of 1 in LaunchDescription([...]) is not an action: a list of actions",
        "write its actions without the inner brackets",
    ),
    "a number among words": python(
        described("Node(executable='x', parameters=[{'a': 4}], arguments=['--count', 3]),"),
        "3]",
        "an int where a text or a substitution is expected",
        "write '3'",
    ),
    "a truth value as condition": python(
        described("LogInfo(msg='x', condition=IfCondition(True)),"),
        "True",
        "a bool where a text or a substitution is expected",
        "write 'true'",
    ),
    "a number as default": python(
        described("DeclareLaunchArgument('rate', default_value=10),"),
        "10)",
        "an int where a text or a substitution is expected",
        "write '10'",
    ),
    "bytes as a text": python(
        described("LogInfo(msg=['a', b'/c']),"),
        "b'",
        "bytes where a text or a substitution is expected",
        "write '/c'",
    ),
    "a path of another class": python(
        described("LogInfo(msg=['a', __import__('pathlib').PurePosixPath('/c')]),"),
        "__import__",
        "a PurePosixPath where a text or a substitution is expected",
        "write str(__import__('pathlib').PurePosixPath('/c'))",
    ),
    "a list among substitutions": python(
        described("LogInfo(msg=['a', ['b', 'c']]),"),
        "LogInfo(",
        "a list among texts and substitutions",
        "write its items without the inner brackets",
    ),
    "a message by position": python(
        described("LogInfo('hello'),"),
        "LogInfo(",
        "LogInfo takes its arguments by name",
        "write LogInfo(msg='hello')",
    ),
    "actions by position": python(
        """
        def generate_launch_description():
            return LaunchDescription(LogInfo(msg='a'), LogInfo(msg='b'))  # here
        """,
        "LaunchDescription(",
        "LaunchDescription takes one list of actions",
        "write LaunchDescription([LogInfo(msg='a'), LogInfo(msg='b')])",
    ),
    "launch_arguments as a dictionary": python(
        """
        def generate_launch_description():
            return LaunchDescription([
                IncludeLaunchDescription(
                    os.path.join(os.path.dirname(__file__), 'child.launch.xml'),
                    launch_arguments={'count': '2'})])  # here
        """,
        "launch_arguments",
        "launch_arguments takes pairs of name and value",
        "write launch_arguments={...}.items()",
    ),
    # ---- returns
    "a forgotten return": python(
        """
        def generate_launch_description():  # here
            ld = LaunchDescription()
            ld.add_action(LogInfo(msg='x'))
        """,
        "def generate",
        "generate_launch_description() returned NoneType, not a LaunchDescription",
        "write 'return ld' at its end",
    ),
    "a forgotten return of the whole": python(
        """
        def generate_launch_description():  # here
            LaunchDescription([LogInfo(msg='x')])
        """,
        "def generate",
        "generate_launch_description() returned NoneType, not a LaunchDescription",
        "write 'return' in front of LaunchDescription([...])",
    ),
    # ---- imports
    "from launch.action": python(
        "from launch.action import ExecuteProcess  # here\n",
        "from launch",
        "launch.action.ExecuteProcess is not provided by this launcher",
        "write 'from launch.actions import ExecuteProcess'",
    ),
    "a node from launch": python(
        "from launch.actions import Node  # here\n",
        "from launch",
        "launch.actions.Node is not provided by this launcher",
        "write 'from launch_ros.actions import Node'",
    ),
    "a misspelt module": python(
        "from launch.subsitutions import LaunchConfiguration  # here\n",
        "launch.subsitutions",
        "No module named 'launch.subsitutions'",
        "did you mean 'launch.substitutions'?",
    ),
    "an attribute of the wrong module": python(
        """
        import launch
        def generate_launch_description():
            return LaunchDescription([launch.actions.LaunchConfiguration('x')])  # here
        """,
        "launch.actions",
        "module 'launch.actions' has no attribute 'LaunchConfiguration'",
        "write 'from launch.substitutions import LaunchConfiguration'",
    ),
    "a name that was not imported": python(
        described("SetParameter('use_sim_time', True),"),
        "SetParameter(",
        "name 'SetParameter' is not defined",
        "write 'from launch_ros.actions import SetParameter'",
    ),
    # ---- classes derived from those of launch
    "a substitution without perform": python(
        """
        class Today(Substitution):
            def preform(self, context):  # here
                return 'Monday'
        def generate_launch_description():
            return LaunchDescription([LogInfo(msg=['it is ', Today()])])
        """,
        "preform(",
        "the substitution Today has no method perform()",
        "write 'def perform(self, context)' instead of 'def preform'",
    ),
}
