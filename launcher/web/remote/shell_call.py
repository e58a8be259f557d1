"""A command of a shell, with its answer in JSON, as a process that ends with the call."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Mapping, Sequence
from typing import Any

from launcher.base import strict_json
from launcher.base.errors import ExitCode
from launcher.base.run_verb import BadCallError
from launcher.control.console.guard import guarded

MOST_COMMANDS = 16  # at the same time: each is a process
_CODES: dict[int, str] = {ExitCode.USAGE: "bad-option", ExitCode.NOT_READY: "timeout"}
_ERROR, _HINT = "error: ", "hint: "


class ShellCalls:
    """Runs commands, each behind a guard: it ends with the call, and with this process."""

    def __init__(self) -> None:
        self._open = 0
        self._endings: set[asyncio.Task[int]] = set()

    async def carry_out(
        self, words: Sequence[str], variables: Mapping[str, str], limit_s: float
    ) -> dict[str, Any]:
        """The document that `launcher WORDS --json` prints; BadCallError, and at the limit.

        `variables` are set besides ours. If the task is cancelled, the command is ended.
        """
        if self._open >= MOST_COMMANDS:
            raise BadCallError("refused", f"{MOST_COMMANDS} commands are being carried out already")
        orders, lifeline = os.pipe()
        self._open += 1
        try:
            code, out, err = await self._run(words, variables, limit_s, orders)
        except (TimeoutError, asyncio.TimeoutError):
            text = f"'{words[0]}' took more than {limit_s:g} s, and was ended"
            raise BadCallError("timeout", text) from None
        finally:
            self._open -= 1
            os.close(lifeline)  # ends it, if it has not ended
        if code:
            raise _failure(code, err.decode(errors="replace"))
        return _document(out)

    async def _run(
        self, words: Sequence[str], variables: Mapping[str, str], limit_s: float, orders: int
    ) -> tuple[int | None, bytes, bytes]:
        try:
            guard = await asyncio.create_subprocess_exec(
                *guarded([words[0], "--json", *words[1:]], orders),
                stdin=asyncio.subprocess.DEVNULL,
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.PIPE,
                env={**os.environ, **variables},
                pass_fds=[orders],
                start_new_session=True,
            )
        finally:
            os.close(orders)
        try:
            out, err = await asyncio.wait_for(guard.communicate(), limit_s)
        finally:
            if guard.returncode is None:
                ending = asyncio.create_task(guard.wait())
                self._endings.add(ending)
                ending.add_done_callback(self._endings.discard)
        return guard.returncode, out, err

    async def close(self) -> None:
        """Wait until the commands that were given up have ended: they have a few seconds."""
        if self._endings:
            await asyncio.wait(self._endings)


def _document(out: bytes) -> dict[str, Any]:
    try:
        found = strict_json.loads(out)
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise BadCallError("internal", "the command has printed no JSON object")
    found.pop("version", None)  # as the answers of a run
    return found


def _failure(code: int, err: str) -> BadCallError:
    """The error and the hint that a command has printed."""
    lines = err.splitlines()
    errors = [line.removeprefix(_ERROR) for line in lines if line.startswith(_ERROR)]
    at = next((place for place, line in enumerate(lines) if line.startswith(_HINT)), None)
    hint = None if at is None else "\n".join(lines[at:]).removeprefix(_HINT)
    message = errors[-1] if errors else (lines[-1] if lines else f"exit code {code}")
    return BadCallError(_CODES.get(code, "failed"), message, hint)
