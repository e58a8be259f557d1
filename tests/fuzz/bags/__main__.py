"""`python -m tests.fuzz.bags [--count N] [--first N] [KIND ...]`: mutate, and print the table."""

from __future__ import annotations

import argparse
import sys

from tests.fuzz.bags.campaign import cores, run
from tests.fuzz.bags.seeds import KINDS


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz.bags", description=__doc__)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=", ".join(KINDS))
    parser.add_argument("--count", type=int, default=3000, help="bags of all kinds (3000)")
    parser.add_argument("--first", type=int, default=0, help="number of the first mutation")
    options = parser.parse_args()
    kinds = options.kinds or KINDS
    of_each = -(-options.count // len(kinds))
    result = run(kinds, range(options.first, options.first + of_each), cores())
    for problem in result.problems:
        print(problem)
    for line in result.lines():
        print(line)
    return int(bool(result.problems))


if __name__ == "__main__":
    sys.exit(main())
