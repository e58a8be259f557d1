"""The tools as a server of the package `mcp`."""

from __future__ import annotations

from typing import Any

import mcp_types as types
from mcp.server.lowlevel.server import Server
from mcp.shared.exceptions import MCPError

from launcher import __version__
from launcher.base import strict_json
from launcher.base.run_verb import BadCallError
from launcher.web.remote.tool import Tool
from launcher.web.remote.toolbox import Toolbox, ToolOutcome

_INSTRUCTIONS = """\
Looks at a running ROS 2 launch and controls its processes. `ps` lists the processes with their
state, `logs` and `events` what happened, `graph` the nodes and topics, and `wait` waits until
processes, topics, services or nodes are there."""
_RUNS = " If several runs are active, `runs` lists them, and the argument `run` chooses one."
_NO_TOOLS = ("unknown-verb", "read-only")


def server_of(toolbox: Toolbox) -> Server[Any]:
    """A server that lists the tools and carries them out; `run` serves a transport."""

    async def list_tools(context: Any, params: Any) -> types.ListToolsResult:
        return types.ListToolsResult(tools=list(map(_as_tool, toolbox.tools.values())))

    async def call_tool(context: Any, params: types.CallToolRequestParams) -> types.CallToolResult:
        try:
            outcome = await toolbox.call(params.name, params.arguments or {})
        except BadCallError as error:
            if error.code in _NO_TOOLS:
                text = ": ".join(filter(None, [error.message, error.hint]))
                raise MCPError(types.INVALID_PARAMS, text) from None
            return _failed(error)
        return _done(outcome)

    return Server(
        "launcher",
        version=__version__,
        instructions=_INSTRUCTIONS + (_RUNS if "runs" in toolbox.tools else ""),
        on_list_tools=list_tools,
        on_call_tool=call_tool,
    )


def _as_tool(tool: Tool) -> types.Tool:
    return types.Tool(
        name=tool.name,
        description=tool.description,
        input_schema=tool.schema(),
        annotations=types.ToolAnnotations(read_only_hint=tool.is_read_only, open_world_hint=False),
    )


def _done(outcome: ToolOutcome) -> types.CallToolResult:
    text = "\n".join(outcome.text) or strict_json.dumps(outcome.result, ensure_ascii=False)
    return types.CallToolResult(
        content=[types.TextContent(text=text)], structured_content=outcome.result
    )


def _failed(error: BadCallError) -> types.CallToolResult:
    text = "\n".join(filter(None, [error.message, error.hint and f"hint: {error.hint}"]))
    return types.CallToolResult(
        content=[types.TextContent(text=text)],
        structured_content={"error": error.document},
        is_error=True,
    )
