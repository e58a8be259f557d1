"""From a saved file to the first status of the robot that has loaded it, under `--watch`."""

from __future__ import annotations

import time
from pathlib import Path

from benchmarks.harness import Row, median, milliseconds, scratch
from benchmarks.warm import (
    _FILE,
    _ROBOT,
    COLD,
    OFTEN,
    SETTLE_S,
    TIMEOUT_S,
    WARM,
    Run,
    _domain,
    _node_script,
    _wait_for,
)

SAVES = 20
LIMIT_S = 0.6


def save(runs: int) -> list[Row]:
    """A module of a robot is saved 20 times; 0.2 s of the time are the wait for more changes."""
    found = {how: _saves(how) for how in (COLD, WARM)}
    detail = f"of {SAVES}; {milliseconds(found[WARM])}; cold {milliseconds(found[COLD])}"
    what = "save a file to the first status of the restarted robot"
    return [Row(what, median(found[WARM]), " s", LIMIT_S, detail)]


def _saves(how: str) -> list[float]:
    with _domain() as domain, scratch() as folder:
        part = folder / "part.py"
        part.write_text("NUMBER = 0\n")
        script = _node_script(folder, _ROBOT.replace("import time\n", "import time\nimport part\n"))
        text = _FILE.format(script=script, count=1, parameters=[OFTEN])
        with domain.running(text, how, "--watch") as run:
            _wait_for(run, "published", 1)
            _wait_for_watching(run, part)
            found = []
            for number in range(SAVES):
                time.sleep(SETTLE_S)
                saved = time.monotonic()
                part.write_text(f"NUMBER = {number + 1}\n")
                found.append(_wait_for(run, "published", number + 2)[-1] - saved)
    return found


def _wait_for_watching(run: Run, part: Path) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while str(part) not in str(run.ask("watch")):
        if time.monotonic() > deadline:
            raise TimeoutError(run.screen)
        time.sleep(0.1)
