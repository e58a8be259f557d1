"""The page of a run in the browser: the process of its server (launcher.web.web_server)."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from launcher.base import strict_json
from launcher.base.errors import LauncherError
from launcher.base.run_verb import BadCallError
from launcher.run.helpers.client_process import ClientProcess
from launcher.run.part import Part
from launcher.web.page_options import require_page, settings_of

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.part import VerbRequest
    from launcher.run.run import Run

GOODBYE_S = 4.0  # for pages to read that the run has ended
MODULE = "launcher.web.web_server"

Done = Callable[["dict[str, Any]"], None]


class WebPage(Part):
    """The server of the page, started with the run, or when the link is asked for.

    The link holds a secret: it is shown on the screen and not written to the log files. It stays
    the same if the server has to be restarted.
    """

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        assert run.socket is not None
        self._settings = settings_of(run.options, run.socket)
        self._link: str | None = None
        self._waiting: list[Done] = []
        self._process = self._new_process()

    def _new_process(self) -> ClientProcess:
        process = ClientProcess(
            self.run,
            (MODULE,),
            name="the server of the page",
            without="there is no page in the browser",
            goodbye_s=GOODBYE_S,
            on_line=self._heard,
            on_exit=self._died,
        )
        process.greeting = strict_json.packed(self._settings).encode()
        return process

    def greeting(self) -> Mapping[str, object]:
        """The link, for the status bar of the console."""
        return {} if self._link is None or self.pid is None else {"page": self._link}

    def _show(self, text: str) -> None:
        self.run.screen.log("INFO", "launch", text)

    @property
    def pid(self) -> int | None:
        return self._process.pid

    def begin(self) -> None:
        self._process.start()

    def serve_page(self) -> None:
        """Start its server if that is not running; UsageError if a library is missing."""
        if self.pid is None:
            require_page("the page")
            self._link = None
            self._settings = settings_of(self.run.options, self._settings["socket"])
            self._process = self._new_process()
            self._process.start()

    def ask_link(self, done: Done) -> None:
        """Call `done` with `{"link": URL}` when the page works, or with `{"error": TEXT}`."""
        if self.pid is None:
            done({"error": "the server of the page is not running"})
        elif self._link is not None:
            done({"link": self._link})
        else:
            self._waiting.append(done)

    def _heard(self, line: bytes) -> None:
        answer = strict_json.unpacked(line)
        if "warning" in answer:
            self._show(f"warning: {answer['warning']}")
            return
        if "link" in answer:
            if answer["link"] != self._link:
                self._show(f"page: {answer['link']}")
            self._link = answer["link"]
            self._settings |= {"port": answer["port"], "token": answer["token"]}
            self._process.greeting = strict_json.packed(self._settings).encode()
        else:
            self._process.give_up()  # it would fail again
        self._answer(answer)

    def _died(self, is_restarted: bool) -> None:
        if not is_restarted:  # else it answers when it works again
            self._answer({"error": "the server of the page died"})

    def _answer(self, answer: dict[str, Any]) -> None:
        waiting, self._waiting = self._waiting, []
        for done in waiting:
            done(answer)

    def close(self) -> None:
        """Report to the pages that the run has ended, and wait for the server's exit."""
        self._process.send(b"end")
        self._process.close()
        self._answer({"error": "the run has ended"})


def serve(request: VerbRequest) -> None:
    """The verb `web`: the link when the page works, started if needed; BadCallError."""
    page, exchange = request.run.parts.need(WebPage), request.exchange
    try:
        page.serve_page()
    except LauncherError as error:
        raise BadCallError("wrong-state", error.message, error.hint) from None

    def done(answer: Mapping[str, Any]) -> None:
        if "error" in answer:
            exchange.fail(BadCallError("wrong-state", f"no page: {answer['error']}"))
        else:
            exchange.reply({"link": answer["link"]}, [answer["link"]])

    page.ask_link(done)
