"""JUnit, annotations, artifacts, repeats and baselines of smoke runs."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from junitparser import Error, Failure, JUnitXml

from tests.smoke.process.bench import BRIEF, PATIENT, SHORT, Bench

MIXED = """
    for: 60 s
    expect:
      - {name: heard, log: here, process: brief}
      - name: "not <heard> & \\x1b[1m"
        log: there
"""


def test_junit_has_one_case_for_each_expectation(bench: Bench):
    bench.write(BRIEF)
    bench.expect(MIXED)
    path = bench.folder / "deep" / "out.xml"
    bench.smoke(f"--junit={path}")
    (suite,) = JUnitXml.fromfile(str(path))
    cases = {case.name: case for case in suite}
    failed = cases.pop("not <heard> & \ufffd[1m")
    assert (suite.tests, suite.failures, suite.errors) == (3, 1, 0)
    (failure,) = failed.result
    assert isinstance(failure, Failure)
    assert "expected: a line with 'there'" in failure.text
    assert [case.result for case in cases.values()] == [[], []]
    assert {case.classname for case in cases.values()} == {"tested.launch.py"}


@pytest.mark.thorough
def test_junit_has_an_error_where_the_run_itself_failed(bench: Bench):
    bench.write(PATIENT)
    path = bench.folder / "out.xml"
    bench.smoke("--ready-within=0.2", "--expect-node=/nobody", f"--junit={path}")
    (suite,) = JUnitXml.fromfile(str(path))
    errors = [r for case in suite for r in case.result if isinstance(r, Error)]
    assert [error.message for error in errors] == ["not ready in time"]


def test_annotations_lead_to_the_line_of_the_expectation(bench: Bench):
    bench.write(BRIEF)
    bench.expect(MIXED)
    done = bench.smoke("--github")
    (line,) = [x for x in done.stdout.splitlines() if x.startswith("::error ")]
    assert re.match(r"::error file=[^,]*tested\.expect\.yaml,line=5,title=not met%3A ", line)
    assert "%0A    seen:     no such line among 1" in line


def test_a_workflow_gets_annotations_and_a_summary_by_itself(bench: Bench):
    bench.write(BRIEF)
    bench.expect(MIXED)
    path = bench.folder / "summary.md"
    path.write_text("before\n", encoding="utf-8")
    bench.environment.update(GITHUB_ACTIONS="true", GITHUB_STEP_SUMMARY=str(path))
    done = bench.smoke()
    assert [line for line in done.stdout.splitlines() if line.startswith("::error file=")]
    before, title, _, head, _, *rows = path.read_text(encoding="utf-8").splitlines()
    assert (before, title, head) == (
        "before",
        "### smoke: tested.launch.py",
        "|  | expectation | expected | seen |",
    )
    assert any(re.match(r"\| met \| heard \| [^|]*here[^|]* \| [^|]+ \|$", row) for row in rows)
    unmet = "| NOT MET | not &#60;heard&#62; &#38; &#92;x1b&#91;1m |"
    assert any(row.startswith(unmet) for row in rows)
    assert "smoke&#58; 2 of 3 expectations met, exit code 3" in rows


@pytest.mark.thorough
def test_a_summary_of_several_runs_says_how_often_expectations_were_met(bench: Bench):
    bench.write(BRIEF)
    bench.expect(MIXED)
    path = bench.folder / "summary.md"
    bench.environment.update(GITHUB_ACTIONS="true", GITHUB_STEP_SUMMARY=str(path))
    bench.smoke("--repeat=2")
    rows = path.read_text(encoding="utf-8").splitlines()
    assert any(row.startswith("| always | 2 of 2 | heard |") for row in rows)
    assert "smoke&#58; 0 of 2 runs without a failure" in rows


@pytest.mark.thorough
def test_a_summary_that_cannot_be_written_is_a_warning(bench: Bench):
    bench.write(BRIEF)
    bench.environment.update(GITHUB_ACTIONS="true", GITHUB_STEP_SUMMARY=str(bench.folder))
    done = bench.smoke("--no-file", "--expect-log=here")
    assert done.returncode == 0
    assert "smoke: warning: cannot write GITHUB_STEP_SUMMARY" in done.stderr


@pytest.mark.thorough
def test_a_workflow_may_go_without_them(bench: Bench):
    bench.write(BRIEF)
    path = bench.folder / "summary.md"
    bench.environment.update(GITHUB_ACTIONS="true", GITHUB_STEP_SUMMARY=str(path))
    done = bench.smoke("--no-file", "--no-github", "--expect-log=there")
    assert (done.returncode, "::error" in done.stdout, path.exists()) == (3, False, False)


def test_a_refused_launch_file_is_in_the_summary(bench: Bench):
    path = bench.folder / "summary.md"
    bench.environment.update(GITHUB_ACTIONS="true", GITHUB_STEP_SUMMARY=str(path))
    done = bench.smoke()
    assert (done.returncode, "::error title=smoke::" in done.stdout) == (2, True)
    assert "not found" in path.read_text(encoding="utf-8")


def test_the_evidence_is_complete(bench: Bench):
    bench.write(PATIENT)
    bench.expect("{expect: [{name: heard, log: here, within: 60 s}]}")
    done = bench.smoke()
    assert "note: no drawing of the ROS graph: no ROS node was observed" in done.stdout
    names = {path.name for path in bench.evidence.iterdir()}
    assert names >= {
        "smoke.log",
        "report.json",
        "launch.log",
        "events.jsonl",
        "plan.json",
        "expectations.yaml",
        "launcher.out",
        "log",
    }
    told = (bench.evidence / "smoke.log").read_text("utf-8")
    assert "met      heard: after" in told and "the system stopped in" in told
    assert "\x1b" not in told


@pytest.mark.thorough
def test_artifacts_without_an_option_are_kept_of_a_failed_run_only(bench: Bench, tmp_path: Path):
    bench.environment["ROS_LOG_DIR"] = str(tmp_path)
    bench.write(PATIENT)
    bench.keeps_evidence = False
    good = bench.smoke("--for=1")
    assert (good.returncode, list(tmp_path.glob("smoke/*"))) == (0, [])
    bad = bench.smoke("--for=1", "--expect-log=never", "--junit=/dev/full")
    (kept,) = tmp_path.glob("smoke/*")
    assert bad.returncode == 3 and f"the evidence is in {kept}" in bad.stdout
    assert (kept / "report.json").exists()
    assert "cannot write --junit /dev/full: No space left on device" in bad.stdout


@pytest.mark.thorough
def test_repeats_report_flaky_expectations(bench: Bench):
    # Every second run has another line.
    bench.write(
        f'sh("coin", "if mkdir {bench.folder}/flip; then echo heads; '
        f'else rmdir {bench.folder}/flip; echo tails; fi"),'
    )
    done = bench.smoke("--for=60", "--repeat=3", "--expect-log=heads", "--expect-log=heads|tails")
    assert done.returncode == 3
    rows = [re.split(r"  +", line.strip()) for line in done.stdout.splitlines()]
    found = {row[2]: row[:2] for row in rows if row[0] in ("always", "FLAKY", "NEVER")}
    assert found["log heads"] == ["FLAKY", "2 of 3"]
    assert found["log heads|tails"] == ["always", "3 of 3"]
    assert "smoke: 2 of 3 runs without a failure" in done.stdout
    assert (bench.evidence / "run-3" / "report.json").exists()


@pytest.mark.thorough
def test_a_baseline_is_written_once_and_held_afterwards(bench: Bench):
    bench.write(PATIENT)
    path = bench.folder / "baseline.json"
    # What a process computes is known from its third second on.
    first = bench.smoke("--for=10", f"--baseline={path}")
    assert first.returncode == 0 and "smoke: wrote" in first.stdout
    document = json.loads(path.read_text("utf-8"))
    assert {"start_up", "cpu patient", "memory patient"} <= document["measures"].keys()
    document["tolerances"]["start_up"]["least"] = 600
    path.write_text(json.dumps(document), encoding="utf-8")
    second = bench.smoke("--for=10", f"--baseline={path}")
    assert second.returncode == 0, second.stdout

    document["measures"]["memory patient"]["value"] = -100
    path.write_text(json.dumps(document), encoding="utf-8")
    third = bench.smoke("--for=2.2", f"--baseline={path}", f"--junit={bench.folder / 'out.xml'}")
    assert third.returncode == 3
    assert "WORSE  baseline: memory patient" in third.stdout
    assert 'name="baseline: memory patient"' in (bench.folder / "out.xml").read_text("utf-8")


@pytest.mark.thorough
def test_no_baseline_is_made_of_a_bad_run(bench: Bench):
    bench.write(SHORT)
    path = bench.folder / "baseline.json"
    done = bench.smoke("--for=60", f"--baseline={path}")
    assert done.returncode == 1
    assert "no baseline is written" in done.stdout and not path.exists()
