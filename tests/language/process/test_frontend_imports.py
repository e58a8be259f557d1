"""Modules that are imported when an XML launch file is loaded."""

from __future__ import annotations

import subprocess
import sys

XML = '<launch><log message="m"/></launch>'


def test_xml_files_load_without_anything_heavy() -> None:
    code = (
        "import io, sys; from launcher.language.frontends.xml import XmlParser; "
        f"entity, parser = XmlParser.load(io.StringIO({XML!r})); "
        "parser.parse_description(entity); "
        "heavy = {'yaml', 'rich', 'psutil', 'asyncio', 'rclpy', 'lark', 'importlib.metadata'}; "
        "print(sorted(heavy & set(sys.modules)))"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "[]"
