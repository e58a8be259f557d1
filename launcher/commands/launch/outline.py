"""Prints the tree of a launch file; the page in the browser and `smoke` run this.

`python -m launcher.commands.launch.outline WORDS`, with the words of a launch, prints one JSON
array, and nothing if the launch file cannot be planned.
"""

from __future__ import annotations

import sys

from launcher.commands.launch.planned import print_planned
from launcher.render.outline import outline

if __name__ == "__main__":
    sys.exit(print_planned(sys.argv[1:], outline))
