"""A bag as the expectation, on a real node."""

from __future__ import annotations

import subprocess
import sys

import pytest

from launcher.bag.reader import Bag
from tests.smoke.process.bench import Bench, talking
from tests.support.bags import message, write_bag

EXPECTED = """
for: 6 s
expect:
  - {name: there, node: /talker, within: 60 s}
  - {name: alike, like: LIKE}
"""


def likeness(bench: Bench, period_s: float, entry: str) -> None:
    """A bag in which `/steady` has this period; the node publishes it every 0.2 s."""
    folder = bench.folder / f"every-{period_s}"
    write_bag(folder, [message("/steady", n * period_s, "x") for n in range(30)])
    good = bench.folder / "good.mcap"
    good.unlink(missing_ok=True)
    words = ["bag", "convert", str(folder), "-o", str(good)]
    subprocess.run([sys.executable, "-m", "launcher", *words], check=True, timeout=120)
    bench.expect(EXPECTED.replace("LIKE", entry))


@pytest.mark.thorough
def test_a_run_is_like_one_bag_and_unlike_another(bench: Bench):
    bench.write(talking())
    likeness(bench, 0.01, "good.mcap")
    done = bench.smoke()
    assert done.returncode == 3, done.stdout
    assert bench.outcomes() == {"there": "met", "alike": "violated", "no unexpected exits": "met"}
    assert "/steady: 100 Hz in good.mcap, " in bench.judged("alike")["seen"]
    recording = bench.evidence / "recording"
    assert Bag(str(recording)).extent.counts.keys() == {"/steady"}

    # A busy machine makes a timer skip periods.
    likeness(bench, 0.2, "{bag: good.mcap, rates: 80 %, gaps: 5000 %}")
    done = bench.smoke()
    assert done.returncode == 0, done.stdout
    assert not recording.exists()


def test_a_bag_that_is_not_there_is_told_before_anything_starts(bench: Bench):
    bench.write(talking())
    bench.expect(EXPECTED.replace("LIKE", "bad.mcap"))
    done = bench.smoke()
    assert done.returncode == 2
    assert "tested.expect.yaml:5: there is no bag at " in done.stderr
    assert not bench.evidence.exists() or not list(bench.evidence.glob("smoke.log"))


@pytest.mark.thorough
def test_the_evidence_of_a_failure_has_what_was_published(bench: Bench):
    bench.write(talking())
    bench.expect(EXPECTED.split("  - {name: alike")[0] + "  - {name: never, topic: /none}\n")
    done = bench.smoke("--bag")
    assert done.returncode == 124, done.stdout
    snapshot = bench.evidence / "snapshot"
    assert Bag(str(snapshot / "bag")).extent.counts["/steady"] > 0
    assert "last /steady of talker" in (snapshot / "index.txt").read_text()

    bench.expect(EXPECTED.split("  - {name: alike")[0])
    assert bench.smoke("--bag").returncode == 0
    assert not snapshot.exists()
