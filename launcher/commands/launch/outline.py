"""Prints the tree of a launch file; the page in the browser and `smoke` run this.

`python -m launcher.commands.launch.outline WORDS`, with the words of a launch, prints one JSON
array, and nothing if the launch file cannot be planned.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence

from launcher.commands import launch
from launcher.commands import plan as planning
from launcher.commands.launch.target import LaunchRequest
from launcher.errors import ExitCode, LauncherError
from launcher.render.outline import outline


def main(words: Sequence[str]) -> int:
    try:
        plan = planning.evaluate(LaunchRequest.of(launch.COMMAND.parse(words)))
    except LauncherError as error:
        return error.exit_code
    if plan.error is not None:
        return ExitCode.USAGE
    print(json.dumps(outline(plan)))
    return ExitCode.OK


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
