"""The error for a verb of ros2cli, or of the console, that a shell lacks, with an alternative."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence

from launcher.base.errors import PackageNotFoundError, UsageError
from launcher.base.program import program
from launcher.base.verb_table import ABSENT_VERBS, CONSOLE_VERBS
from launcher.language.frontends.locate import locate
from launcher.packages.finder import share_directory


def refuse(words: Sequence[str]) -> None:
    """UsageError unless a launch file or a package has the name of this verb."""
    verb = words[0]
    if not _is_target(words):
        if verb in CONSOLE_VERBS:
            message = f"'{verb}' exists only in the console of a running launch"
        else:
            message = f"ros2cli's verb '{verb}' does not exist here"
        hint = {**ABSENT_VERBS, **CONSOLE_VERBS}[verb] or "PROGRAM --help lists the verbs"
        raise UsageError(message, hint=hint.replace("PROGRAM", program()))


def _is_target(words: Sequence[str]) -> bool:
    with contextlib.suppress(UsageError):
        locate(words[:1], os.environ)
        return True
    with contextlib.suppress(PackageNotFoundError):
        share_directory(words[0], os.environ)
        return len(words) > 1
    return False
