"""Print the number of tests of each folder and tier, and their time, as Markdown.

make check && python -m tools.tiers build/*.xml
"""

from __future__ import annotations

import sys
from collections import Counter, defaultdict
from collections.abc import Iterable
from xml.etree import ElementTree

TIERS = ("unit", "basic", "thorough")


def rows(paths: Iterable[str]) -> Iterable[tuple[str, ...]]:
    """(folder, one cell per tier); a cell is `tests, seconds`."""
    tests: dict[tuple[str, str], set[str]] = defaultdict(set)
    seconds: Counter[tuple[str, str]] = Counter()
    for path in paths:
        for case in ElementTree.parse(path).iter("testcase"):
            tier = case.find("properties/property[@name='tier']")
            if tier is not None:
                key = (case.attrib["classname"].split(".")[1], tier.attrib["value"])
                tests[key].add(f"{case.attrib['classname']}::{case.attrib['name']}")
                seconds[key] += float(case.attrib["time"])
    for folder in sorted({folder for folder, _ in tests}):
        cells = ((len(tests[folder, tier]), seconds[folder, tier]) for tier in TIERS)
        yield (f"`tests/{folder}`", *(f"{n}, {s:.0f} s" if n else "" for n, s in cells))


def main() -> None:
    print("| folder |", " | ".join(TIERS), "|")
    print("|---" * (len(TIERS) + 1) + "|")
    for row in rows(sys.argv[1:]):
        print("|", " | ".join(row), "|")


if __name__ == "__main__":
    main()
