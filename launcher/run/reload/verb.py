"""The verb `reload`: what it has done, or would do, for users and for programs."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.base.errors import LauncherError, LaunchFileError
from launcher.base.run_verb import BadCallError
from launcher.base.text import count
from launcher.run.parts import DRY_RUN
from launcher.run.reload.reload import Change, ComparedProcess, Reloader
from launcher.run.requests.results import sentence

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.part import Exchange, VerbRequest


def serve(request: VerbRequest) -> None:
    """Carry out the request; BadCallError."""
    reloader, exchange = request.run.parts.need(Reloader), request.exchange
    try:
        if request.call.options.get(DRY_RUN.name):
            _answer(exchange, reloader.compare())
        else:
            reloader.reload(lambda entries: _answer(exchange, entries))
    except LaunchFileError as error:
        raise BadCallError("bad-launch-file", _message(error), error.hint) from None
    except LauncherError as error:
        code = "bad-launch-file" if error.exit_code == 2 else "wrong-state"
        raise BadCallError(code, _message(error), error.hint) from None


def _message(error: LauncherError) -> str:
    """The error with its place and line, without its hint."""
    text = error.render().removeprefix("error: ")
    return text.removesuffix(f"\nhint: {error.hint}") if error.hint else text


def _answer(exchange: Exchange, entries: Sequence[ComparedProcess]) -> None:
    exchange.reply({"processes": [_document(one) for one in entries]}, lines(entries))


def _document(one: ComparedProcess) -> dict[str, Any]:
    return {
        "name": one.name,
        "change": one.change.value,
        "details": list(one.details),
        "done": one.result is None or one.result.done,
        "text": "" if one.result is None else sentence(one.result),
    }


def lines(entries: Sequence[ComparedProcess]) -> list[str]:
    """A line for each change, and one for what is the same."""
    changes = [one for one in entries if one.change is not Change.SAME]
    same = [one.name for one in entries if one.change is Change.SAME]
    width = max((len(one.name) for one in changes), default=0)
    text = [_line(one, width) for one in changes]
    if not changes:
        return [f"nothing has changed: {count(len(same), 'process')} as in the launch file"]
    return [*text, f"the same: {', '.join(same)}"] if same else text


def _line(one: ComparedProcess, width: int) -> str:
    line = f"{one.change.value:<7}  {one.name:<{width}}  {'; '.join(one.details)}".rstrip()
    return line if one.result is None else f"{line}\n{'':7}  {sentence(one.result)}"
