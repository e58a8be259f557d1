"""From a saved file to the first status of the robot that has loaded it, under `--watch`."""

from __future__ import annotations

import time

from benchmarks.harness import Row, median, milliseconds, scratch
from benchmarks.warm.domain import COLD, OFTEN, ROBOT, SETTLE_S, WARM, nodes_file, private_domain

SAVES = 20
LIMIT_S = 0.6


def save(runs: int) -> list[Row]:
    """A module of a robot is saved 20 times; 0.2 s of the time are the wait for more changes."""
    found = {how: _saves(how) for how in (COLD, WARM)}
    detail = f"of {SAVES}; {milliseconds(found[WARM])}; cold {milliseconds(found[COLD])}"
    what = "save a file to the first status of the restarted robot"
    return [Row(what, median(found[WARM]), " s", LIMIT_S, detail)]


def _saves(how: str) -> list[float]:
    with private_domain() as domain, scratch() as folder:
        part = folder / "part.py"
        part.write_text("NUMBER = 0\n")
        program = ROBOT.replace("import time\n", "import time\nimport part\n")
        text = nodes_file(folder, program, parameters=OFTEN)
        with domain.running(text, how, "--watch") as run:
            run.times("published", 1)
            run.wait_for(lambda: str(part) in str(run.ask("watch")), pause_s=0.1)
            found = []
            for number in range(SAVES):
                time.sleep(SETTLE_S)
                saved = time.monotonic()
                part.write_text(f"NUMBER = {number + 1}\n")
                found.append(run.times("published", number + 2)[-1] - saved)
    return found
