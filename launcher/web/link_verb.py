"""The verb `web`: the link of the page in the browser, whose server is started if needed."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.base.errors import LauncherError
from launcher.base.run_verb import BadCallError
from launcher.web.web_page import WebPage

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.part import VerbRequest


def serve(request: VerbRequest) -> None:
    """Answer with the link when the page works; BadCallError."""
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
