"""`graph` and `wait` of `launcher mcp` look at the nodes of the run, wherever that is."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from launcher.posix.domain_lease import leased_domain
from tests.support.controlled_run import ControlledRun
from tests.support.mcp_client import with_client

if TYPE_CHECKING:
    from mcp.client import Client

PUB = f"{sys.executable} -m launcher topic pub /chatter std_msgs/msg/String 'data: x'"


@pytest.mark.thorough
def test_they_look_at_the_domain_of_the_run(tmp_path: Path):
    file = tmp_path / "talker.launch.xml"
    file.write_text(f'<launch><executable name="talker" cmd="{PUB}"/></launch>')

    async def use(client: Client) -> None:
        async def ask(name: str, **arguments: Any) -> dict[str, Any]:
            result = await client.call_tool(name, arguments)
            assert not result.is_error, result.content
            return result.structured_content

        found = await ask("wait", names=["talker"], topics=["/chatter"], timeout=50)
        assert [one["holds"] for one in found["conditions"]] == [True, True]
        graph = await ask("graph", include="chatter", hidden=True)  # as the node of `topic`
        assert "/chatter" in graph["topics"]
        assert [one["direction"] for one in graph["endpoints"]] == ["publisher"]

    with leased_domain() as domain, tempfile.TemporaryDirectory(prefix="run-") as runtime:
        here = {**os.environ, "XDG_RUNTIME_DIR": runtime, "TMPDIR": runtime}
        there = {**here, "ROS_DOMAIN_ID": str(domain)}
        command = [sys.executable, "-m", "launcher", str(file), "--no-console"]
        screen = tmp_path / "screen"
        with ControlledRun(command, env=there, runtime=Path(runtime), screen=screen) as run:
            assert run.socket
            with_client(here, use)
