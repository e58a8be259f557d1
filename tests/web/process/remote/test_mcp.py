"""`launcher mcp` with real runs: the SDK's client, raw JSON-RPC, the end."""

from __future__ import annotations

import signal
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import psutil
import pytest

from launcher.base.errors import ExitCode
from launcher.control.console.guard import GUARD
from tests.support.children import is_alive
from tests.support.mcp_client import RawMcp, mcp_error, with_client
from tests.support.waiting import wait_until
from tests.web.process.remote.conftest import StartRun

if TYPE_CHECKING:
    from mcp.client import Client


async def answer(client: Client, name: str, **arguments: Any) -> dict[str, Any]:
    """The structured answer of a tool that succeeds."""
    result = await client.call_tool(name, arguments)
    assert not result.is_error, result.content
    return result.structured_content


async def error(client: Client, name: str, **arguments: Any) -> dict[str, Any]:
    """The error of a tool that fails; its text has the message and the hint."""
    result = await client.call_tool(name, arguments)
    assert result.is_error
    found = result.structured_content["error"]
    text = result.content[0].text
    assert found["message"] in text and (found["hint"] or "") in text
    return found


@pytest.mark.parametrize("mode", ["auto", pytest.param("legacy", marks=pytest.mark.thorough)])
def test_a_client_looks_at_a_run_and_controls_it(
    start: StartRun, environment: dict[str, str], mode: str
):
    run = start()

    async def use(client: Client) -> None:
        tools = {tool.name: tool for tool in (await client.list_tools()).tools}
        assert tools["ps"].annotations.read_only_hint is True
        assert tools["stop"].annotations.read_only_hint is False
        assert tools["stop"].input_schema["required"] == ["names"]
        await answer(client, "wait", names=["cat"], timeout=50)
        assert [one["name"] for one in (await answer(client, "ps"))["processes"]] == ["cat-1"]
        await answer(client, "send", names=["cat"], text="hello")
        run.wait_for_log("cat", "hello")
        shown = await client.call_tool("logs", {"names": ["cat"], "limit": 1})
        assert shown.content[0].text == "[cat-1] hello"
        assert [line["text"] for line in shown.structured_content["lines"]] == ["hello"]
        stopped = await answer(client, "stop", names=["cat"])
        assert stopped["processes"][0]["done"] is True
        assert run.row("cat")["state"] == "STOPPED"
        last = await answer(client, "events", limit=1)
        assert len(last["events"]) == 1 and last["omitted"] > 0
        again = await error(client, "stop", names=["cat"])
        assert again["code"] == "wrong-state"
        unknown = await error(client, "start", names=["dog"])
        assert unknown["code"] == "unknown-name"
        await answer(client, "start", names=["cat"])
        assert [one["id"] for one in (await answer(client, "runs"))["runs"]] == [run.socket.stem]

    with_client(environment, use, mode=mode)


@pytest.mark.thorough
def test_the_run_is_chosen_by_each_call(start: StartRun, environment: dict[str, str]):
    async def use(client: Client) -> None:
        none = await error(client, "ps")
        assert (none["code"], none["message"]) == ("no-run", "no active run")
        first = start()
        assert (await answer(client, "ps"))["processes"]
        second = start()
        several = await error(client, "ps")
        assert several["code"] == "unknown-run"
        assert first.socket.stem in several["hint"] and "the argument 'run'" in several["hint"]
        await answer(client, "quit", run=first.socket.stem)
        first.exit_code()
        assert (await answer(client, "ps", run=str(second.process.pid)))["processes"]
        await answer(client, "ps")
        second.process.send_signal(signal.SIGINT)
        second.exit_code()
        assert (await error(client, "ps"))["code"] == "no-run"
        late = await error(client, "wait", names=["cat"], timeout=0.2)
        assert late["code"] == "timeout"

    with_client(environment, use)


def test_a_server_that_only_reads_has_no_other_tools(start: StartRun, environment: dict[str, str]):
    run = start()

    async def use(client: Client) -> None:
        names = {tool.name for tool in (await client.list_tools()).tools}
        assert "ps" in names and not names & {"stop", "kill", "quit", "send", "runs"}
        assert (await answer(client, "ps"))["processes"]
        for name, problem in (
            ("stop", "'stop' changes something"),
            ("nothing", "unknown tool"),
            ("mute", "'mute'"),
        ):
            with pytest.raises(mcp_error(), match=problem):
                await client.call_tool(name, {"names": ["cat"]})

    with_client(environment, use, "--read-only", "--run", run.socket.stem)
    assert run.row("cat")["pid"] is not None


def waiting_command(server: RawMcp) -> psutil.Process:
    """The command of a call, behind its guard."""
    me = psutil.Process(server.process.pid)
    found: list[psutil.Process] = []

    def is_there() -> bool:
        lines = {one: one.cmdline() for one in me.children(recursive=True)}
        found[:] = [one for one, line in lines.items() if "wait" in line and GUARD not in line]
        return bool(found)

    wait_until(is_there, "the command that waits")
    return found[0]


def test_stdout_has_only_the_protocol_and_nothing_outlives_stdin(environment: dict[str, str]):
    with RawMcp(environment) as server:
        hello = server.initialize()
        assert hello["serverInfo"]["name"] == "launcher"
        assert "tools" in hello["capabilities"]
        tools = server.ask("tools/list")["result"]["tools"]
        assert {"ps", "wait"} <= {tool["name"] for tool in tools}
        assert server.call("ps")["result"]["isError"] is True
        assert server.call("no-tool")["error"]["code"] == -32602
        assert server.ask("no/method")["error"]["code"] == -32601
        assert server.process.stdin is not None and server.process.stdout is not None
        server.process.stdin.write("\nno JSON\n")
        server.process.stdin.flush()
        assert '"id": null, "error": {"code": -32700' in server.process.stdout.readline()
        waiting = server.send("tools/call", name="wait", arguments={"names": ["cat"]})
        child = waiting_command(server)
        server.notify("notifications/cancelled", requestId=waiting)
        wait_until(lambda: not is_alive(child.pid), "its end after it was cancelled")
        server.send("tools/call", name="wait", arguments={"names": ["cat"]})
        child = waiting_command(server)
        out, err = server.process.communicate(timeout=60)
        assert all('"jsonrpc"' in line for line in out.splitlines())
        assert (server.process.returncode, err) == (0, "")
        assert not is_alive(child.pid)


def test_a_server_ends_when_its_client_does_not_read_any_more(environment: dict[str, str]):
    with RawMcp(environment) as server:
        server.initialize()
        assert server.process.stdout is not None and server.process.stderr is not None
        server.process.stdout.close()
        server.send("ping")
        assert server.process.wait(60) == 0
        assert server.process.stderr.read() == ""


@pytest.mark.parametrize("signum", [signal.SIGTERM, signal.SIGKILL], ids=lambda one: one.name)
def test_a_signal_ends_a_server_and_its_commands(
    environment: dict[str, str], signum: signal.Signals
):
    with RawMcp(environment) as server:
        server.initialize()
        server.send("tools/call", name="wait", arguments={"names": ["cat"]})
        child = waiting_command(server)
        server.process.send_signal(signum)
        ends = {signal.SIGTERM: ExitCode.TERMINATED, signal.SIGKILL: -signal.SIGKILL}
        assert server.process.wait(60) == ends[signum]
        wait_until(lambda: not is_alive(child.pid), "the end of the command")


def test_without_the_package_the_error_has_the_command_that_installs_it(
    environment: dict[str, str],
):
    code = (
        "import sys; sys.modules['mcp'] = None\n"
        "from launcher.cli.dispatch import main; sys.exit(main(['mcp']))"
    )
    found = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )

    assert (found.returncode, found.stdout) == (ExitCode.USAGE, "")
    assert "needs the Python package 'mcp'" in found.stderr
    assert "pip install" in found.stderr and "[mcp]" in found.stderr
