"""The verb `web`: the link of the page in the browser, whose server is started if needed."""

from __future__ import annotations

from collections.abc import Mapping

from launcher.base.errors import LauncherError
from launcher.control.peer import Exchange
from launcher.control.verbs import BadCallError
from launcher.run.run_control import RunControl

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def answer(control: RunControl, exchange: Exchange) -> None:
    """Answer with the link when the page works; BadCallError."""
    assert control.open_page is not None
    try:
        page = control.open_page()
    except LauncherError as error:
        raise BadCallError("wrong-state", error.message, error.hint) from None

    def done(answer: Mapping[str, Any]) -> None:
        if "error" in answer:
            exchange.fail(BadCallError("wrong-state", f"no page: {answer['error']}"))
        else:
            exchange.reply({"link": answer["link"]}, [answer["link"]])

    page.ask_link(done)
