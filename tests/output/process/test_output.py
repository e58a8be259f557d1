"""Where the output of processes goes, and with which colours."""

from __future__ import annotations

import re
import subprocess

import pytest

from tests.support.benches import TIMEOUT_S, Bench

WRITES = "sh('echo to stdout; echo to stderr >&2', output={})"

# What `output=` puts on the screen and into files of its own (CONFORMANCE 1.30). The run's
# launch.log and the process's own file hold everything, whatever it says.
OUTPUTS = {
    "'log'": ("stderr", []),
    "'screen'": ("stdout stderr", []),
    "'both'": ("stdout stderr", []),
    "'own_log'": ("", ["sh-1-stderr.log", "sh-1-stdout.log"]),
    "'full'": ("stdout stderr", ["sh-1-stderr.log", "sh-1-stdout.log"]),
    "{'stdout': 'log', 'stderr': 'screen'}": ("stderr", []),
    "{'stdout': 'screen'}": ("stdout", []),
    "{'both': {'screen', 'log', 'own_log'}}": ("stdout stderr", []),
    "{'stdout': {'screen', 'own_log'}, 'stderr': 'log'}": ("stdout", ["sh-1-stdout.log"]),
    "{}": ("", []),
}


def _shown(done: subprocess.CompletedProcess[bytes]) -> str:
    return " ".join(re.findall(r"^\[sh-1\] to (\w+)$", done.stdout.decode(), re.M))


@pytest.mark.parametrize("output", OUTPUTS)
def test_the_output_goes_where_it_was_asked_to_go(bench: Bench, output: str):
    screen, files = OUTPUTS[output]
    done = bench.run(WRITES.format(output))
    run = bench.folder / "log" / "latest"
    assert done.returncode == 0
    assert _shown(done) == screen
    assert sorted(path.name for path in run.glob("sh-1-*.log")) == files
    for path in run.glob("sh-1-*.log"):
        assert path.read_text() == f"[sh-1] to {path.stem.rpartition('-')[2]}\n"
    assert (run / "sh-1.log").read_text().count("[sh-1] to ") == 2


@pytest.mark.parametrize("output", ["'bogus'", "{'both': 'bogus'}", "{'bogus': 'screen'}"])
def test_an_output_that_does_not_exist_is_refused(bench: Bench, output: str):
    done = bench.run(WRITES.format(output))
    assert done.returncode == 2
    assert b"bogus" in done.stderr
    assert b"not valid" in done.stderr or b"not a valid" in done.stderr


def test_an_environment_variable_sets_the_output_and_the_option_overrides_it(bench: Bench):
    bench.env["OVERRIDE_LAUNCH_PROCESS_OUTPUT"] = "own_log"
    assert _shown(bench.run(WRITES.format("'screen'"))) == ""
    assert _shown(bench.run(WRITES.format("{'stdout': 'screen'}"), "-a")) == "stdout stderr"
    bench.env["OVERRIDE_LAUNCH_PROCESS_OUTPUT"] = "bogus"
    assert bench.run(WRITES.format("'screen'")).returncode == 2


# ---- colours

COLOURED = r"""
printf '\033[31mred\033[0m %s\n' $RCUTILS_COLORIZED_OUTPUT
printf '\033[31mred\033[0m no newline'
"""

# environment -> (colour of the prefix, of the process, what rcutils is told)
PIPED = {
    "": (False, False, "0"),
    "NO_COLOR=1": (False, False, "0"),
    "NO_COLOR=": (False, False, "0"),
    "FORCE_COLOR=1": (True, True, "1"),
    "FORCE_COLOR=0": (False, False, "0"),
    "NO_COLOR=1 FORCE_COLOR=1": (False, False, "0"),
    "RCUTILS_COLORIZED_OUTPUT=1": (False, True, "1"),
    "RCUTILS_COLORIZED_OUTPUT=0": (False, False, "0"),
    "RCUTILS_COLORIZED_OUTPUT=1 NO_COLOR=1": (False, False, "1"),
    "RCUTILS_COLORIZED_OUTPUT=0 FORCE_COLOR=1": (True, True, "0"),
}
ON_A_TERMINAL = {
    "": (True, True, "1"),
    "NO_COLOR=1": (False, False, "0"),
    "FORCE_COLOR=0": (False, False, "0"),
    "TERM=dumb": (False, False, "0"),
    "RCUTILS_COLORIZED_OUTPUT=0": (True, True, "0"),
}


def _coloured(bench: Bench, words: str) -> str:
    """The actions of a process that writes in colours, in this environment."""
    bench.env.pop("RCUTILS_COLORIZED_OUTPUT", None)
    bench.env.update(word.split("=") for word in words.split())
    (bench.folder / "coloured.sh").write_text(COLOURED)
    return f'sh(". {bench.folder}/coloured.sh")'


def _assert_coloured(text: str, expected: tuple[bool, bool, str]) -> None:
    prefix, process, told = expected
    (line,) = re.findall(rf"^.*red.* {told}\r*$", text, re.M)
    (last,) = re.findall(r"^.*red.* no newline.*$", text, re.M)
    assert ("\x1b[38;5;" in line) is prefix
    assert ("\x1b[31mred" in line) is process
    assert ("\x1b[31mred" in last) is process


@pytest.mark.thorough
@pytest.mark.parametrize("words", PIPED)
def test_colour_in_a_pipe_comes_only_when_it_is_asked_for(bench: Bench, words: str):
    actions = _coloured(bench, words)
    _assert_coloured(bench.run(actions).stdout.decode(), PIPED[words])
    log = (bench.folder / "log" / "latest" / "launch.log").read_text()
    assert "\x1b" not in log
    assert log.count("] red") == 2


@pytest.mark.thorough
@pytest.mark.parametrize("words", ON_A_TERMINAL)
def test_colour_on_a_terminal_goes_when_it_is_not_wanted(bench: Bench, words: str):
    terminal = bench.terminal(_coloured(bench, words))
    assert terminal.exit_code() == 0
    _assert_coloured(terminal.raw, ON_A_TERMINAL[words])


def test_only_colour_sequences_reach_the_terminal_also_in_the_rest_of_a_prompt(bench: Bench):
    title, clear, others = r"\033]0;title\007", r"\033[2J", r"\007\005\177\233\033[8m"
    steps = [
        f"printf 'name{title}? '",
        "sleep 0.3",
        f"printf 'bo{clear}{others}'",
        "sleep 0.3",
        "echo b",
    ]
    actions = f'sh("{"; ".join(steps)}")'.replace("\\", "\\\\")
    terminal = bench.terminal(actions, "--no-console")  # which has codes of its own
    assert terminal.exit_code() == 0
    assert "[sh-1] name? bob\n" in terminal.text
    assert not re.search("\x1b\\]|\x1b\\[2J|\x1b\\[8m|[\x07\x05\x7f\x9b\ufffd]", terminal.raw)


def test_output_to_a_full_disk_is_reported_once_and_fails_the_run(bench: Bench):
    talks = "for i in 1 2 3; do echo $i; sleep 0.05; done"
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            bench.command(f'sh("{talks}")'),
            env=bench.env,
            stdout=full,
            stderr=subprocess.PIPE,
            timeout=TIMEOUT_S,
            check=False,
        )
    assert done.returncode == 1
    told = (
        b"error: cannot write the output: No space left on device; what does not fit is dropped\n"
    )
    assert done.stderr == told
    run = bench.folder / "log" / "latest"
    assert (run / "sh-1.log").read_text() == "[sh-1] 1\n[sh-1] 2\n[sh-1] 3\n"
    log = (run / "launch.log").read_text()
    assert "process has finished cleanly" in log and "bytes of output: the disk was full" in log
    assert '"exit_code": 1' in (run / "events.jsonl").read_text()


def test_output_to_a_full_disk_is_not_reported_to_a_full_disk(bench: Bench):
    with open("/dev/full", "w") as full:
        words = bench.command('sh("echo hi")')
        done = subprocess.run(words, env=bench.env, stdout=full, stderr=full, timeout=TIMEOUT_S)
    assert done.returncode == 1


NODE_LINES = r"""sh('''printf "[WARN] [1763852000.123456] [robot]: hot\\n  very\\n"
printf "go on? "; sleep 0.5; echo yes''', name="robot")"""


def test_compact_lines_on_the_screen_leave_the_log_files_as_they_are(bench: Bench):
    done = bench.run(NODE_LINES, "--format", "compact")
    clock = r"\d\d:\d\d:\d\d\.\d{3}"
    begun, hot, very, asked, *_ = done.stdout.decode().splitlines()[2:]
    assert re.fullmatch(rf"{clock} I robot process started with pid \[\d+\]", begun)
    assert re.fullmatch(rf"{clock} W robot hot", hot)
    assert very == " " * 21 + "  very"
    assert re.fullmatch(rf"{clock} I robot go on\? yes", asked)
    log = (bench.folder / "log/latest/robot-1.log").read_text()
    assert log.startswith("[robot-1] [WARN] [1763852000.123456] [robot]: hot\n[robot-1]   very\n")


def test_a_template_forms_the_lines_on_the_screen(bench: Bench):
    done = bench.run(NODE_LINES, "--format", "<{severity} {name}> {message}")
    assert b"\n<WARN robot> hot\n               very\n<INFO robot> go on? yes\n" in done.stdout
    assert b"\n<INFO launch> exit code 0: " in done.stdout
    refused = bench.run(NODE_LINES, "--format", "compcat")
    assert refused.returncode == 2
    assert b"--format: unknown format 'compcat'; did you mean 'compact'?" in refused.stderr


def test_nodes_that_write_in_another_format_are_understood(bench: Bench):
    bench.env["RCUTILS_CONSOLE_OUTPUT_FORMAT"] = "{severity}/{name}/{message}"
    action = 'sh("echo WARN/robot/hot", name="robot")'
    assert b" W robot hot\n" in bench.run(action, "--format", "compact").stdout
    assert b"[robot-1] WARN/robot/hot\n" in bench.run(action).stdout


def test_compact_lines_on_a_terminal_have_the_level_as_a_colour(bench: Bench):
    terminal = bench.terminal(NODE_LINES, "--no-console", "--format", "compact")
    assert terminal.exit_code() == 0
    assert re.search("\x1b\\[38;5;39mrobot\x1b\\[0m \x1b\\[33mhot\x1b\\[0m\r?\n", terminal.raw)
    assert re.search(r"^\d\d:\d\d:\d\d\.\d{3} robot go on\? yes$", terminal.text, re.M)


QUIET = 'ExecuteProcess(cmd=["sh", "-c", "echo a; echo b; printf c; echo d >&2"], name="quiet")'


def test_lines_that_only_a_log_has_are_counted_unless_that_was_chosen(bench: Bench):
    reminder = b"only in its log"
    lines = bench.run(QUIET).stdout.decode().splitlines()
    text = "3 lines of quiet-1 are only in its log; output='screen' shows them"
    assert lines[-2] == f"[INFO] [launch]: {text}"
    assert lines[-1].startswith("[INFO] [launch]: exit code 0: ")
    log = (bench.folder / "log" / "latest" / "quiet-1.log").read_text()
    assert log.count("[quiet-1] ") == 4
    assert reminder not in bench.run(WRITES.format("'log'")).stdout
    assert reminder not in bench.run('ExecuteProcess(cmd=["sh", "-c", "echo >&2"])').stdout
    assert reminder not in bench.run(QUIET, "-a").stdout
    bench.env["OVERRIDE_LAUNCH_PROCESS_OUTPUT"] = "log"
    assert reminder not in bench.run(QUIET).stdout
