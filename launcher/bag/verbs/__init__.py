"""`bag VERB ...`: record topics, play and look at recordings."""

from __future__ import annotations

import functools

from launcher.bag.verbs import check, compare, convert, info, play, record
from launcher.base.command_line import Command
from launcher.base.verb_table import VERBS
from launcher.ros.verb import dispatch

COMMAND = Command(
    "bag",
    VERBS["bag"],
    commands=(
        record.COMMAND,
        play.COMMAND,
        info.COMMAND,
        convert.COMMAND,
        compare.COMMAND,
        check.COMMAND,
    ),
)

main = functools.partial(dispatch, COMMAND)
