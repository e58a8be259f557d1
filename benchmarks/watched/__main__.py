"""`python -m benchmarks.watched`: see the package."""

from __future__ import annotations

import argparse
import time

from benchmarks.harness import NotHereError
from benchmarks.watched.injections import INJECTIONS
from benchmarks.watched.trials import summary, trials


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="*", default=[*INJECTIONS], help="of faults")
    parser.add_argument("--seeds", type=int, default=10)
    given = parser.parse_args()
    for kind in given.kinds:
        found = []
        try:
            for one in trials(kind, range(given.seeds)):
                found.append(one)
                print(f"  {time.strftime('%H:%M:%S')} {one}", flush=True)
        except NotHereError as error:
            print(f"| {kind} | not tried: {error} |", flush=True)
            continue
        print(f"| {kind} | {summary(found)} |", flush=True)


if __name__ == "__main__":
    main()
