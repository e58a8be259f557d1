"""The tools that one server offers, and their calls."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from launcher.base.model.record import Record
from launcher.base.run_verb import BadCallError
from launcher.base.text import did_you_mean
from launcher.control import verbs
from launcher.control.active_runs import find_run
from launcher.control.answer_lines import event_line
from launcher.control.client import Reply
from launcher.control.protocol import REQUEST_LIMIT, Request, node_variables
from launcher.web.remote import run_call, tool_table
from launcher.web.remote.shell_call import ShellCalls
from launcher.web.remote.tool import RUN, Tool

_ID_BYTES = 32
_END_S = 10.0  # for a command to end by itself at the limit that it was given


class ToolOutcome(Record):
    """What a call has found: `result` for programs, `text` for people, in lines."""

    result: dict[str, Any]
    text: tuple[str, ...] = ()


class Toolbox:
    """`socket` is that of the only run; None: each call chooses one, by default `run`.

    With `read_only` there are only tools that change nothing.
    """

    def __init__(
        self, *, socket: Path | None = None, run: str | None = None, read_only: bool = False
    ) -> None:
        self._socket = socket
        self._run = run
        self._read_only = read_only
        self._shell = ShellCalls()
        self.tools = tool_table.tools(
            read_only=read_only, chooses_run=socket is None and run is None
        )

    async def call(self, name: str, arguments: Mapping[str, Any]) -> ToolOutcome:
        """Carry a tool out; BadCallError, with the codes of the control protocol and others."""
        tool = self.tool(name)
        given = tool.checked(arguments)
        which = given.pop(RUN, self._run)
        if tool.verb is None:
            return await self._of_shell(tool, given, which)
        limit = given.pop(tool_table.LIMIT, None)
        names = given.pop("names", [])
        if limit is not None and tool.verb.option("lines") is not None:
            given["lines"] = limit
        verbs.check(name, names, given)  # before a run is looked for
        if len(Request(None, name, tuple(names), given).line()) > REQUEST_LIMIT - _ID_BYTES:
            raise BadCallError("bad-request", f"the arguments take more than {REQUEST_LIMIT} bytes")
        reply = await run_call.ask(
            lambda: self._find(which, tool.is_read_only), name, names, given, tool.limit_s
        )
        return _outcome(tool, reply, limit)

    def tool(self, name: str) -> Tool:
        """The tool of this name; BadCallError."""
        tool = self.tools.get(name)
        if tool is not None:
            return tool
        if self._read_only and name in tool_table.tools():
            raise BadCallError("read-only", f"'{name}' changes something, and this only reads")
        hint = did_you_mean(name, list(self.tools)) or tool_table.LEFT_OUT.get(name)
        raise BadCallError("unknown-verb", f"unknown tool '{name}'", hint)

    def _find(self, which: str | None, read_only: bool) -> Path:
        if self._socket is not None:
            return self._socket
        return find_run(which, read_only=read_only).path

    async def _of_shell(self, tool: Tool, given: dict[str, Any], which: str | None) -> ToolOutcome:
        variables: dict[str, str] = {}
        words = [tool.name]
        if tool.name != "runs":
            may_begin = tool.name == "wait"
            variables, run = await self._surroundings(which, may_begin=may_begin)
            if may_begin and given.get("names") and run is not None:
                words.append(f"--run={run}")
        limit_s = given.get("timeout", tool.limit_s - _END_S) + _END_S
        document = await self._shell.carry_out([*words, *tool.words(given)], variables, limit_s)
        return ToolOutcome(document)

    async def _surroundings(
        self, which: str | None, *, may_begin: bool
    ) -> tuple[dict[str, str], str | None]:
        """(variables with which the nodes of a run are found, its id), as far as there is one."""
        try:
            run = await run_call.first_line(lambda: self._find(which, True))
        except BadCallError as error:
            is_absent = error.code == run_call.NO_RUN and which is None  # nodes of others
            if is_absent or (may_begin and error.code in run_call.ABSENT):
                return {}, which
            raise
        return node_variables(run), run["id"]

    async def close(self) -> None:
        """Wait for the end of what was given up."""
        await self._shell.close()


def _outcome(tool: Tool, reply: Reply, limit: int | None) -> ToolOutcome:
    result, text = reply.result, reply.text
    if tool.name == "events":
        text = tuple(map(event_line, result["events"]))
    if limit is None:
        return ToolOutcome(result, text)
    key = next((key for key, value in result.items() if isinstance(value, list)), None)
    if key is None:
        return ToolOutcome(result, text)
    entries, dropped = result[key], max(0, len(result[key]) - limit)
    if len(text) == len(entries):
        text = text[dropped:]
    more = {"omitted": dropped} if dropped else {}
    return ToolOutcome({**result, key: entries[dropped:], **more}, text)
