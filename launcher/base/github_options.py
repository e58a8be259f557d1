"""The options of verbs that report to a workflow of GitHub Actions."""

from __future__ import annotations

import os

from launcher.base.command_line import option
from launcher.base.github import is_on

OPTIONS = (
    option(
        "--github",
        "print annotations for GitHub Actions, and add to the summary of the step; default where "
        "GITHUB_ACTIONS is true",
    ),
    option("--no-github", "do not, there either"),
)
EXCLUSIVE = ("github", "no_github")


def is_wanted(*, github: bool, no_github: bool) -> bool:
    return github or (is_on(os.environ) and not no_github)
