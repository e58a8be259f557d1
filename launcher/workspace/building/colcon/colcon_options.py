"""Options of colcon, checked without colcon, which is not started if nothing has changed."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Collection, Sequence

from launcher.base.errors import ExitCode, UsageError
from launcher.base.program import program
from launcher.base.text import did_you_mean
from launcher.workspace.building.build_place import Place

# Of the extensions that the launcher needs; those of others are asked for: this takes a second.
_USUAL = re.findall(
    r"\S+",
    "--help --test-result-base --merge-install --continue-on-error --executor --parallel-workers "
    "--event-handlers --ignore-user-meta --metas --paths --packages-ignore "
    "--packages-ignore-regex --packages-up-to --packages-up-to-regex --packages-above "
    "--packages-above-and-dependencies --packages-above-depth --packages-select-by-dep "
    "--packages-skip-by-dep --packages-skip-up-to --packages-select-build-failed "
    "--packages-skip-build-finished --packages-select-test-failures --packages-skip-test-passed "
    "--packages-select --packages-skip --packages-select-regex --packages-skip-regex "
    "--packages-start --packages-end --cmake-args --cmake-target --cmake-target-skip-unavailable "
    "--cmake-clean-cache --cmake-clean-first --cmake-force-configure --ament-cmake-args "
    "--catkin-cmake-args --catkin-skip-building-tests",
)
_COLCON = "import sys; from colcon_core.command import main; sys.exit(main(argv=sys.argv[1:]))"


def check(words: Sequence[str]) -> None:
    """UsageError for options that colcon does not have, and words that belong to none."""
    if words and not words[0].startswith("-"):
        raise UsageError(
            f"'{words[0]}' is not an option of colcon",
            hint=f"packages go behind --packages-select: {program()} build -- --packages-select "
            "NAME",
        )
    takes_any = False  # as --cmake-args does: what is no option of colcon is an argument of CMake
    for word in words:
        flag = word.partition("=")[0]
        if not flag.startswith("--"):
            continue
        if _is_in(flag, _USUAL) or (not takes_any and _is_in(flag, _all())):
            takes_any = flag.endswith("-args")
        elif not takes_any:
            raise UsageError(f"colcon has no option '{flag}'", hint=did_you_mean(flag, _USUAL))


def _is_in(flag: str, known: Collection[str]) -> bool:
    """Whether the option is known, or the beginning of one that is."""
    return any(one.startswith(flag) for one in known)


def _all() -> list[str]:
    """The options of colcon with all extensions that are installed."""
    return re.findall(r"--[\w-]+", _colcon("build", "--help").stdout)


def selected(place: Place, words: Sequence[str]) -> set[str]:
    """The names of the packages that the options `--packages-...` among the words select.

    UsageError for a value that colcon refuses.
    """
    folders = ("--base-paths", place.base, "--build-base", place.build)
    done = _colcon("--log-base", os.devnull, "list", "--names-only", *folders, *words)
    if done.returncode == ExitCode.USAGE:
        raise UsageError(done.stderr.strip().rpartition("error: ")[2])
    return {*done.stdout.split()}


def _colcon(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", _COLCON, *words]
    return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
