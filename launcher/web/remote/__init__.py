"""Runs for other programs: an MCP server, and the same as OpenAPI (docs/guides/programs.md).

Both offer *tools*, which are made from the rows of verbs.

Doors: `verb` is `launcher mcp`. The page's server (`web`) has `http_api`, its routes, and with them
`mcp_endpoint`.

* `tool_table` makes a `tool` of each verb, with an `argument` for each option; it also says which
  verbs are no tools, and why.
* `toolbox` carries out calls: `run_call` is a request to the control socket of a run, `shell_call`
  a command of a shell, such as `graph`.
* `mcp_server` has the tools for the package `mcp`, which is imported only here and in
  `mcp_endpoint`; `openapi` describes them as OpenAPI.
"""
