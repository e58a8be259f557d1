"""Output files of smoke: checked before the run, complete or absent, and pruned."""

from __future__ import annotations

import contextlib
import io
import os
import resource
import signal
from pathlib import Path
from xml.etree import ElementTree

import pytest

from launcher.base.errors import ExitCode, LauncherError, LaunchFileError, SeveralErrors
from launcher.smoke.expect.expectation import Decision, Expectation, Verdict
from launcher.smoke.judges.run import forced_stop
from launcher.smoke.observe.facts import Ending
from launcher.smoke.reports import github, junit, text_report
from launcher.smoke.reports.artifacts import KEPT, evidence, prune, refuse_unwritable, save
from launcher.smoke.reports.failure import describe
from launcher.smoke.reports.result import Judged, SmokeResult
from launcher.smoke.run.smoke_progress import PipeSafeStdout, SmokeProgress
from launcher.smoke.run.smoke_session import Options
from tests.smoke.unit.facts import ended, lines, seen, signalled

# ---- beforehand


def refused(**wanted: Path) -> str:
    given: dict[str, Path | None] = {"artifacts": None, "junit": None, "baseline": None, **wanted}
    with pytest.raises(LauncherError) as told:
        refuse_unwritable(repeat=2, **given)
    assert told.value.exit_code is ExitCode.USAGE
    return told.value.render()


def test_all_unwritable_paths_are_reported_at_once(tmp_path: Path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    (tmp_path / "evidence" / "run-2" / "report.json").mkdir(parents=True)
    told = refused(
        artifacts=tmp_path / "evidence", junit=tmp_path / "file" / "x.xml", baseline=tmp_path
    )
    assert "run-2/report.json" in told and "--artifacts" in told
    assert "x.xml: File exists, and is not a directory" in told
    assert f"--baseline {tmp_path}: Is a directory" in told


def test_checking_paths_creates_and_changes_no_file(tmp_path: Path):
    old, new = tmp_path / "old.xml", tmp_path / "deep" / "new.json"
    old.write_text("<old/>", encoding="utf-8")
    refuse_unwritable(artifacts=tmp_path / "evidence", junit=old, baseline=new, repeat=2)
    assert list((tmp_path / "evidence").iterdir()) == []
    assert old.read_text(encoding="utf-8") == "<old/>"
    assert (new.exists(), new.parent.is_dir()) == (False, True)


def test_checking_the_path_of_a_recording_leaves_no_folder(tmp_path: Path):
    there = tmp_path / "there"
    there.mkdir()
    for path in (tmp_path / "deep" / "deeper" / "x.yaml", there / "x.yaml", there / "a" / "x"):
        refuse_unwritable(artifacts=None, junit=None, baseline=None, record=path)
    assert [*tmp_path.iterdir()] == [there] and not [*there.iterdir()]
    (tmp_path / "file").write_text("", encoding="utf-8")
    told = refused(record=tmp_path / "file" / "a" / "x.yaml")
    assert "--record" in told and "Not a directory" in told


def test_a_baseline_that_cannot_be_read_is_refused_beforehand(tmp_path: Path):
    path = tmp_path / "base.json"
    path.write_text("{", encoding="utf-8")
    with pytest.raises(LauncherError, match="is not a baseline"):
        Options(words=(), target="x", baseline=path).refuse_unwritable()
    Options(words=(), target="x", baseline=path, update_baseline=True).refuse_unwritable()


# ---- a disk that fills


def test_a_full_disk_is_reported_once_and_the_rest_is_written(tmp_path: Path):
    os.symlink("/dev/full", tmp_path / "smoke.log")
    screen = io.StringIO()
    progress = SmokeProgress(tmp_path, screen)
    for text in ("one", "two"):
        progress.log(1.0, text)
    progress.close()
    told = screen.getvalue().splitlines()
    assert told == [
        "smoke: smoke.log is incomplete: No space left on device",
        "[   1.0 s] one",
        "[   1.0 s] two",
    ]


def test_a_closed_pipe_is_no_failure_and_a_full_disk_is_one():
    reading, writing = os.pipe()
    os.close(reading)
    with contextlib.suppress(BrokenPipeError), open(writing, "w", encoding="utf-8") as stream:
        stdout = PipeSafeStdout(stream)
        print("one", file=stdout, flush=True)
        print("two", file=stdout, flush=True)
        assert stdout.trouble is None
    with contextlib.suppress(OSError), open("/dev/full", "w", encoding="utf-8") as stream:
        stdout = PipeSafeStdout(stream)
        print("one", file=stdout, flush=True)
        assert stdout.trouble == "No space left on device"


def test_a_partly_written_file_is_removed(tmp_path: Path):
    path = tmp_path / "out.xml"
    path.write_text("old", encoding="utf-8")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10, before[1]))
    try:
        with pytest.raises(OSError):
            save(path, "x" * 20)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, ignored)
    assert not path.exists()


# ---- evidence that nobody asked for


def test_artifacts_of_a_passed_run_are_removed_and_of_a_failed_one_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    env = {"ROS_LOG_DIR": str(tmp_path)}
    with evidence(None, env) as good:
        good.is_kept = False
    with evidence(None, env) as bad:
        (bad.path / "report.json").write_text("{}", encoding="utf-8")
    assert (good.path.exists(), [*bad.path.iterdir()]) == (False, [bad.path / "report.json"])
    assert capsys.readouterr().out == f"smoke: the evidence is in {bad.path} (the last 20 stay)\n"


def test_the_latest_artifact_folders_and_those_in_use_are_kept(tmp_path: Path):
    env = {"ROS_LOG_DIR": str(tmp_path)}
    with evidence(None, env) as in_use:
        for number in range(KEPT + 3):
            (in_use.path.parent / f"9999-{number:02}").mkdir()
        prune(in_use.path.parent)
        left = sorted(path.name for path in in_use.path.parent.iterdir())
    assert left == [in_use.path.name, *(f"9999-{number:02}" for number in range(3, KEPT + 3))]


# ---- reports


def judged(name: str, outcome: Decision, *about: str) -> Judged:
    verdict = Verdict(outcome=outcome, expected="it is there", about=about)
    return Judged(expectation=Expectation(kind="node", subject="/a", name=name), verdict=verdict)


def test_last_lines_of_a_process_are_reported_once():
    told: dict[str, str] = {}
    facts = seen(lines=lines("the end"))
    first = describe(judged("a", Decision.VIOLATED, "robot_1-1"), facts, told)
    second = describe(judged("b", Decision.VIOLATED, "robot_1-1"), facts, told)
    assert "the end" in first[-1]
    assert second[-1] == "    last lines of robot_1-1: above, under 'a'"
    assert describe(judged("b", Decision.VIOLATED, "robot_1-1"), facts)[-1] == first[-1]


def test_processes_killed_at_the_stop_are_reported():
    asked = (signalled("robot_1-1", 2, 20.0), signalled("robot_1-1", 15, 25.0))
    assert forced_stop(seen(events=asked)) is None
    assert forced_stop(seen(events=(signalled("robot_1-1", 9, 10.0),))) is None  # before the stop
    verdict = forced_stop(seen(events=(*asked, signalled("robot_1-1", 9, 30.0))))
    assert verdict is not None and verdict.outcome is Decision.VIOLATED
    assert verdict.seen == "killed after 10.0 s: robot_1-1"


def test_processes_that_crash_at_the_stop_are_reported():
    requested = ended("robot_1-1", -2, 20.0, asked=True)
    assert forced_stop(seen(events=(requested, ended("robot_2-2", -11, 10.0)))) is None
    verdict = forced_stop(seen(events=(requested, ended("robot_2-2", -11, 20.0))))
    assert verdict is not None and verdict.outcome is Decision.VIOLATED
    assert (verdict.seen, verdict.about) == ("robot_2-2 ended with SIGSEGV", ("robot_2-2",))


def result(*found: Judged, **more: object) -> SmokeResult:
    given = {"facts": seen(), "folder": Path(), "words": (), "domain_id": 1, **more}
    return SmokeResult(judged=found, **given)  # type: ignore[arg-type]


def test_a_failure_that_only_one_run_reports_is_flaky():
    rows = text_report.flake_rows([result(), result(judged("stop", Decision.VIOLATED)), result()])
    assert [(row.verdict, row.met) for row in rows] == [("FLAKY", 2)]


def test_junit_says_why_a_launch_file_was_not_launched(tmp_path: Path):
    path = tmp_path / "out.xml"
    words = ("error: x.launch.py:1: NameError: name 'a' is not defined", "    a()")
    facts = seen(events=(), ending=Ending(asked_s=None, down_s=1, returncode=2))
    bad = result(judged("a", Decision.MET), facts=facts, trouble="no", last_lines=words)
    junit.write(path, [bad], "x.launch.py")
    (case,) = ElementTree.parse(path).getroot().iter("testcase")
    assert case[0].tag == "error" and (case[0].text or "").splitlines() == ["no", *words]


def test_junit_and_annotations_report_what_was_refused_before_the_run(tmp_path: Path):
    path = tmp_path / "out.xml"
    one = LaunchFileError("there is no type x", hint="did you mean y?", where="a.expect.yaml:3")
    junit.write_refusal(path, SeveralErrors([one, one]), "x.launch.py")
    suite = ElementTree.parse(path).getroot()[0]
    assert (suite.get("tests"), suite.get("errors")) == ("1", "1")
    (error,) = suite.iter("error")
    assert error.get("message") == "a.expect.yaml:3: there is no type x"
    assert (error.text or "").count("hint: did you mean y?") == 2
    told = list(github.refusal(SeveralErrors([one, LauncherError("nothing")])))
    assert told == [
        "::error file=a.expect.yaml,line=3,title=smoke::there is no type x (did you mean y?)",
        "::error title=smoke::nothing",
    ]
