"""What pytest collects of folders with tests of launch_testing: nothing is launched here."""

from __future__ import annotations

import pytest

pytest_plugins = ["pytester"]

DESCRIPTION = """
import pytest

@pytest.mark.launch_test
def generate_test_description(): pass
"""
FAILS = "def test_important(): assert False\n"


@pytest.fixture
def folder(pytester: pytest.Pytester) -> pytest.Pytester:
    pytester.makeini("[pytest]\naddopts = -p no:cacheprovider")
    return pytester


@pytest.mark.parametrize(
    "skip", ["pytest.importorskip('not_there')", "pytest.skip('why', allow_module_level=True)"]
)
def test_a_file_that_skips_itself_leaves_the_others_of_its_folder(folder, skip: str):
    folder.makepyfile(test_a=FAILS, test_b=f"import pytest\n{skip}\n{DESCRIPTION}")
    folder.mkpydir("other")

    result = folder.runpytest_inprocess("-q")

    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.assert_outcomes(failed=1, skipped=1)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("import sys\n{}\nsys.exit(4)\n", "*test_b.py:8: sys.exit(4) ends the program*"),
        ("import not_there\n{}", "*No module named 'not_there'*"),
        ("{}\n1 / 0\n", "*ZeroDivisionError*"),
        ("{}\n)\n", "*SyntaxError*"),
    ],
)
def test_a_fault_of_a_file_is_an_error_of_this_file_only(folder, text: str, said: str):
    folder.makepyfile(test_a=FAILS, test_b=text.format(DESCRIPTION))

    result = folder.runpytest_inprocess("-q", "--continue-on-collection-errors")

    result.assert_outcomes(failed=1, errors=1)
    result.stdout.fnmatch_lines(said)
    result.stdout.no_fnmatch_line("*INTERNALERROR*")


def test_only_what_is_asked_for_is_imported(folder):
    folder.makepyfile(test_a="def test_a(): pass\n", test_b=f"1 / 0\n{DESCRIPTION}")

    assert folder.runpytest_inprocess("-q", "test_a.py").ret == pytest.ExitCode.OK


def test_a_description_is_one_item_and_has_its_marks(folder):
    folder.makepyfile(
        test_a=DESCRIPTION + "def test_not_collected(): pass\n",
        test_b="from test_a import generate_test_description\n",
        test_c="# generate_test_description\n\ndef test_usual(): pass\n",
        test_d="def generate_test_description(): pass\n\ndef test_unmarked(): pass\n",
    )

    def collected(*words: str) -> list[str]:
        said = folder.runpytest_inprocess("-q", "--collect-only", *words).outlines
        return [line for line in said if "::" in line]

    marked = ["test_a.py::test_a", "test_b.py::test_b"]
    assert collected() == [*marked, "test_c.py::test_usual", "test_d.py::test_unmarked"]
    assert collected("-m", "launch_test") == marked


@pytest.mark.parametrize(
    ("word", "hint"), [("n=3", "*did you mean n:=3?"), ("test_a.py", "*a -- ends the arguments*")]
)
def test_malformed_arguments_are_a_mistake_of_the_command_line(folder, word: str, hint: str):
    result = folder.runpytest_inprocess("--launch-args", word)

    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: --launch-args: malformed launch argument*", hint])


NO_READY = "a LaunchDescription containing a ReadyToTest action"


@pytest.mark.parametrize(
    ("body", "said", "most"),
    [
        ("from types import SimpleNamespace as D\n    return D(entities=[])", f"*{NO_READY}", 7),
        ("return {}['x']", "*test_a.py:5: KeyError", 14),
    ],
)
def test_what_a_description_raises_is_shown_without_our_frames(folder, body, said, most):
    folder.makepyfile(test_a=DESCRIPTION.replace("pass", "\n    " + body))

    result = folder.runpytest_inprocess("-q")

    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(said)
    assert len(result.outlines) <= most, result.outlines


def test_a_usual_fixture_of_a_marked_test_fails_this_test_only(folder):
    folder.makepyfile(
        test_a="""
import pytest

@pytest.fixture
def plain(): pass

@pytest.mark.launch(fixture=plain)
def test_marked(): pass

@pytest.mark.launch(fixture="plain")
async def test_named(): pass

def test_other(): pass
"""
    )

    result = folder.runpytest_inprocess("-q")

    result.assert_outcomes(failed=2, passed=1)
    result.stdout.fnmatch_lines(["plain is no launch_pytest fixture*", "'plain' is no launch_py*"])
