"""A page whose run has bytes that are no characters, and sockets that only take room."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import pytest
from websockets.sync.client import connect

from tests.support.waiting import wait_until
from tests.support.web_page import PageClient, cookie_of, get
from tests.web.process.conftest import Start

pytestmark = pytest.mark.thorough


@pytest.fixture
def odd(tmp_path: Path) -> Path:
    """A launch file with a byte that is no character wherever there may be one."""
    folder = os.fsdecode(os.fsencode(tmp_path) + b"/x\xff")
    Path(folder).mkdir()
    path = tmp_path / "odd.launch.py"
    path.write_text(
        "from launch import LaunchDescription\n"
        "from launch.actions import ExecuteProcess\n\n\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([ExecuteProcess(\n"
        "        cmd=['sh', '-c', 'printf \"line \\\\377\\\\n\"; exec cat', '\\udcff'],\n"
        f"        name='n\\udcffame', cwd={folder!a}, output='screen',\n"
        "        additional_env={'ODD': 'a\\udcff'})])\n"
    )
    return path


def test_bytes_that_are_no_characters_reach_the_page_as_replacements(start: Start, odd: Path):
    run, link = start(odd)
    with PageClient(link) as page:
        page.open()
        wait_until(lambda: page.of("plan"), "the plan")
        (process,) = page.of("plan")[-1]["processes"]
        assert process["env_set"] == {"ODD": "a\ufffd"}
        assert process["cmd"][-1] == "\ufffd"
        assert process["cwd"].endswith("/x\ufffd")
        wait_until(lambda: "line \ufffd" in [row[4] for row in page.lines()], "the line")
        for name in ("\udcff", "\ud83d"):
            answer = page.ask("run", verb="stop", names=[name])
            assert answer["error"]["code"] == "unknown-name"
        assert page.ask("tree")["ok"]
        wait_until(lambda: page.of("plan")[-1].get("tree"), "the tree")
        assert page.ask("run", verb="stop", names=["*"])["ok"]
    assert run.ask("ps")["processes"][0]["state"] == "STOPPED"


def test_sockets_without_the_key_keep_nobody_out(start: Start, sleeper: Path):
    _, link = start(sleeper)
    host = link.partition("//")[2].partition("/")[0]
    headers = {"Cookie": cookie_of(link)}
    with contextlib.ExitStack() as stack:
        for _ in range(110):
            stack.enter_context(
                connect(f"ws://{host}/feed", origin=f"http://{host}", additional_headers=headers)
            )
        with PageClient(link) as page:
            page.open()
            assert page.ask("run", verb="info", names=["cat"])["ok"]
    assert get(link)[0] == 200
