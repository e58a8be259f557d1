"""Included files that do not exist, or include each other endlessly."""

from __future__ import annotations

from tests.launch.unit.classic_mistakes.cases import Case, python

ERRORS = {
    "an included file that does not exist": python(
        """
        def generate_launch_description():
            return LaunchDescription([
                IncludeLaunchDescription(
                    os.path.join(os.path.dirname(__file__), 'chlid.launch.xml'))])  # here
        """,
        "chlid",
        "the included launch file FOLDER/chlid.launch.xml does not exist",
        "did you mean 'child.launch.xml'?",
    ),
    "an included file with another suffix": Case(
        '<launch>\n  <include\n      file="$(dirname)/child.launch.py"/>\n</launch>\n',
        3,
        "child",
        "the included launch file FOLDER/child.launch.py does not exist",
        "did you mean 'child.launch.xml'?",
        suffix="xml",
    ),
    "an included file in a folder that does not exist": Case(
        "launch:\n- include:\n    file: $(dirname)/lauch/child.launch.xml\n",
        3,
        "child",
        "the included launch file FOLDER/lauch/child.launch.xml does not exist",
        "the folder FOLDER/lauch does not exist; did you mean 'launch'?",
        suffix="yaml",
    ),
    "an included file that is one folder further": Case(
        "launch:\n- include:\n    file: $(dirname)/deep.launch.xml\n",
        3,
        "deep",
        "the included launch file FOLDER/deep.launch.xml does not exist",
        "did you mean 'launch/deep.launch.xml'?",
        suffix="yaml",
    ),
    "a cycle in XML": Case(
        '<launch>\n  <include file="$(dirname)/back.launch.xml"/>\n</launch>\n',
        2,
        "<include",
        "launch files include each other endlessly: "
        "case.launch.xml -> back.launch.xml -> case.launch.xml",
        "remove an include or a call, or give it a condition that becomes false",
        suffix="xml",
    ),
    "a cycle in YAML": Case(
        "launch:\n- include:\n    file: $(dirname)/case.launch.yaml\n",
        2,
        "- include",
        "the launch file includes itself endlessly: case.launch.yaml -> case.launch.yaml",
        "remove an include or a call, or give it a condition that becomes false",
        suffix="yaml",
    ),
}
