"""The verb `detach`: end the run here, and leave the processes on other hosts to them."""

from __future__ import annotations

from launcher.base.errors import LauncherError
from launcher.base.model.run_events import Asked
from launcher.base.run_verb import BadCallError
from launcher.hosts.engine.fleet import Fleet

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.run.part import VerbRequest
    from launcher.run.processes.process import Process
    from launcher.run.run import Run


def serve(request: VerbRequest) -> None:
    """Detach, and answer with what runs on and what does not; BadCallError."""
    run = request.run
    try:
        left = _left(run)
    except LauncherError as error:
        raise BadCallError("wrong-state", error.message) from None
    run.log.note(Asked("detach"))
    stopped = [one.name for one in run.processes if one.is_awaited]
    dropped = list(run.core.intentions())
    places = ", ".join(f"{one.name} ({_place(one)})" for one in left)
    texts = [f"detached; these run on: {places}"]
    if stopped:
        texts.append(f"stopped, since they run here: {', '.join(stopped)}")
    if dropped:
        texts.append(f"not carried out any more: {', '.join(dropped)}")
    for text in texts:
        run.log.log("INFO", "launch", text)
    run.shutdown.stop("detached")
    result = {
        "left": [{"name": one.name, "host": _place(one)} for one in left],
        "stopped": stopped,
        "withdrawn": dropped,
    }
    request.exchange.reply(result, texts)


def _left(run: Run) -> list[Process]:
    """The processes that run on; LauncherError if there are none."""
    fleet = run.parts.find(Fleet)
    left = [] if fleet is None else fleet.detach()
    if not left:
        raise LauncherError("no process runs on another host")
    return left


def _place(process: Process) -> str:
    host = process.host
    is_away = host is not None and host.unreachable_s is not None
    return f"{process.host_name}, unreachable" if is_away else process.host_name
