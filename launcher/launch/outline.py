"""Prints the tree of a launch file; the page in the browser and `smoke` run this.

`python -m launcher.launch.outline WORDS`, with the words of a launch, prints one JSON
array, and nothing if the launch file cannot be planned.
"""

from __future__ import annotations

import sys

from launcher.launch.plan.outline import outline
from launcher.launch.planned import print_planned

if __name__ == "__main__":
    sys.exit(print_planned(sys.argv[1:], outline))
