"""The results of pytest and ctest, read from recorded JUnit files."""

from __future__ import annotations

import pytest

from launcher.workspace.testing import package_results
from launcher.workspace.testing.package_jobs import Job

PYTEST = """\
<?xml version="1.0" encoding="utf-8"?>
<testsuites><testsuite name="pytest" errors="2" failures="1" skipped="1" tests="5">
<testcase classname="p.test.test_a" name="test_one" file="test/test_a.py" line="3" time="0.1" />
<testcase classname="p.test.test_a" name="test_two" file="test/test_a.py" line="4" time="0.1">
<failure message="AssertionError: not two&#10;assert 1 == 2">test/test_a.py:5: in test_two
    helper(1)
test/helper.py:2: in helper
    assert x == 2
/usr/lib/python3/library.py:7: in inner
E   AssertionError: not two</failure></testcase>
<testcase classname="p.test.test_a" name="test_fix" file="test/test_a.py" line="8" time="0.1">
<error message="failed on setup with &quot;RuntimeError: in fixture&quot;">
no traceback</error></testcase>
<testcase classname="" name="test.test_b" time="0.0">
<error message="collection failure">ImportError while importing test module '/p/test/test_b.py'.
Traceback:
test/test_b.py:1: in &lt;module&gt;
    import ament_flake8.main
E   ModuleNotFoundError: No module named 'ament_flake8'</error></testcase>
<testcase classname="p.test.test_a" name="test_s" time="0.0">
<skipped type="pytest.skip" /></testcase>
</testsuite></testsuites>
"""
CTEST = """\
<?xml version="1.0" encoding="UTF-8"?>
<testsuite name="(empty)" tests="4" failures="1" disabled="0" skipped="1">
<testcase name="test_py" classname="test_py" time="1" status="run" />
<testcase name="test_cpp" classname="test_cpp" time="1" status="run" />
<testcase name="test_bad" classname="test_bad" time="1" status="fail">
<failure message="Failed" /></testcase>
<testcase name="test_off" classname="test_off" time="0" status="notrun">
<skipped message="Unable to find executable" /></testcase>
</testsuite>
"""


COLLECTION = """\
<testsuites><testsuite><testcase classname="" name="test.test_a" time="0.0">
<error message="{message}">{text}</error></testcase></testsuite></testsuites>
"""
IMPORT = """\
ImportError while importing test module '/p/test/test_a.py'.
Traceback:
test/test_a.py:1: in &lt;module&gt;
    import helper
test/helper.py:13: in &lt;module&gt;
    from x.msg import Cuont
E   ImportError: cannot import name 'Cuont' from 'x.msg' (/x/msg/__init__.py)"""
SYNTAX = """\
/usr/lib/python3/ast.py:54: in parse
    return compile(source, filename, mode, flags,
E     File "{folder}/test/test_a.py", line 3
E       def (
E           ^
E   SyntaxError: invalid syntax"""
CHAINED = """\
test/test_a.py:2: in &lt;module&gt;
    {}["a"]
E   KeyError: 'a'

During handling of the above exception, another exception occurred:
test/test_a.py:4: in &lt;module&gt;
    raise ValueError("first: x\\nsecond: y")
E   ValueError: first: x
E   second: y"""
EXIT = """\
Traceback (most recent call last):
  File "/usr/lib/python3/pytest.py", line 333, in wrap_session
  File "{folder}/test/test_a.py", line 1, in &lt;module&gt;
    raise SystemExit(3)
SystemExit: 3"""


@pytest.fixture
def job(tmp_path, monkeypatch):
    """The job of a package in src/p, with the workspace as working directory."""
    source, build = tmp_path / "src/p", tmp_path / "build/p"
    (source / "test").mkdir(parents=True)
    build.mkdir(parents=True)
    for name in ("test_a.py", "test_b.py", "helper.py"):
        (source / "test" / name).touch()
    monkeypatch.chdir(tmp_path)
    return Job(
        "p", str(source), str(source), (), str(build / "pytest.xml"), str(build / "test.log")
    )


def ctest_job(job, tmp_path):
    build = tmp_path / "build/p"
    (build / "ctest.junit").write_text(CTEST, encoding="utf-8")
    own = build / "test_results/p"
    own.mkdir(parents=True)
    return Job("p", job.source, str(build), (), str(own), job.log, is_ctest=True)


def test_results_of_pytest(job, tmp_path):
    (tmp_path / "build/p/pytest.xml").write_text(PYTEST, encoding="utf-8")

    found = package_results.read(job)

    assert (found.passed, found.failed, found.skipped, found.problem) == (1, 3, 1, "")
    assert list(map(str, found.failures)) == [
        "src/p/test/helper.py:2: test_two: AssertionError: not two",
        'src/p/test/test_a.py:9: test_fix: failed on setup with "RuntimeError: in fixture"',
        "src/p/test/test_b.py:1: test.test_b: ModuleNotFoundError: No module named 'ament_flake8'",
    ]
    assert str(found) == "1 passed, 3 failed, 1 skipped"


@pytest.mark.parametrize(
    ("message", "text", "seen"),
    [
        (
            "collection failure",
            IMPORT,
            "helper.py:13: test.test_a: ImportError: cannot import name 'Cuont' from 'x.msg' "
            "(/x/msg/__init__.py)",
        ),
        ("collection failure", SYNTAX, "test_a.py:3: test.test_a: SyntaxError: invalid syntax"),
        ("collection failure", CHAINED, "test_a.py:4: test.test_a: ValueError: first: x"),
        ("collection failure", "no traceback", "test.test_a: collection failure"),
        ("internal error", EXIT, "test_a.py:1: test.test_a: SystemExit: 3"),
    ],
    ids=["import", "syntax", "chained", "unknown", "exit"],
)
def test_the_cause_of_a_module_that_cannot_be_imported(job, tmp_path, message, text, seen):
    text = text.replace("{folder}", job.source)
    document = COLLECTION.replace("{message}", message).replace("{text}", text)
    (tmp_path / "build/p/pytest.xml").write_text(document, encoding="utf-8")

    (failure,) = package_results.read(job).failures

    assert str(failure).removeprefix("src/p/test/") == seen


def test_of_an_interrupted_run_only_failures_count(job, tmp_path):
    (tmp_path / "build/p/pytest.xml").write_text(PYTEST, encoding="utf-8")

    found = package_results.read(job, is_complete=False)

    assert (found.passed, found.failed) == (0, 3)


def test_ctest_counts_the_tests_in_files_of_ament(job, tmp_path):
    job = ctest_job(job, tmp_path)
    (tmp_path / "build/p/test_results/p/test_py.xunit.xml").write_text(PYTEST, encoding="utf-8")

    found = package_results.read(job)

    assert (found.passed, found.failed, found.skipped) == (1 + 1, 3 + 1, 1 + 1)
    assert str(found.failures[-1]) == "test_bad: Failed"


@pytest.mark.parametrize("text", ["", "<testsuite", "\x00"])
def test_a_broken_file_is_a_problem(job, tmp_path, text):
    (tmp_path / "build/p/pytest.xml").write_text(text, encoding="utf-8")
    found = package_results.read(job)
    assert "pytest.xml cannot be read" in found.problem


def test_without_a_file_there_are_no_tests(job):
    assert (str(package_results.read(job)), package_results.read(job).problem) == ("no tests", "")


@pytest.mark.parametrize(
    "line", ["{}/test/test_a.py:3: KeyboardInterrupt", '  File "{}/test/test_a.py", line 3 in test']
)
@pytest.mark.parametrize("folder", ["plain", "with ö and blank"])
def test_the_place_where_a_test_was_ended(job, tmp_path, line, folder):
    source = str(tmp_path / folder)
    written = source.encode("ascii", "backslashreplace").decode() if "File" in line else source
    log = tmp_path / "build/p/test.log"
    elsewhere = '  File "/usr/lib/python3/time.py", line 1 in sleep\n'
    log.write_text(f"{elsewhere}{line.format(written)}\n", encoding="utf-8")

    one = Job("p", source, source, (), "", str(log))

    assert package_results.place_of_end(one) == f"{folder}/test/test_a.py:3"


@pytest.mark.parametrize(
    ("found", "incomplete", "line"),
    [
        ([package_results.Results()], {}, "1 package: no tests"),
        ([package_results.Results()], {"timed out": ["a"]}, "1 package: 1 timed out (a)"),
        (
            [
                package_results.Results(passed=3),
                package_results.Results(failed=1),
                *[package_results.Results()] * 2,
            ],
            {"timed out": ["b", "c"], "not built": ["d"]},
            "4 packages: 3 passed, 1 failed, 2 timed out (b, c), 1 not built (d)",
        ),
    ],
)
def test_the_last_line_names_packages_without_all_their_results(found, incomplete, line):
    assert package_results.total(found, incomplete) == line
