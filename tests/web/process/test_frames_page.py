"""The tree of frames beside the graph, in a real Chromium."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from tests.support.browser import page_at
from tests.support.repository import REPOSITORY
from tests.support.workspaces import TRANSFORM_TYPES, built_once
from tests.web.process.conftest import Start
from tests.web.process.test_fleet_page import show

pytestmark = pytest.mark.browser

LAUNCH = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess


def generate_launch_description():
    command = [sys.executable, "-c", "from tests.support.robot_frames import spin; spin()"]
    return LaunchDescription([ExecuteProcess(cmd=command, cwd={cwd!r}, name="robot")])
"""


def test_frames_are_shown_while_transforms_are_published(
    started: Browser, start: Start, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
):
    base = tmp_path_factory.getbasetemp()
    workspace = built_once(base, "transform_types", TRANSFORM_TYPES)
    file = tmp_path / "robot.launch.py"
    file.write_text(LAUNCH.format(cwd=str(REPOSITORY)))
    _, link = start(file, **workspace.environment(os.environ))

    with page_at(started, link, viewport={"width": 1280, "height": 800}) as page:
        show(page, "graph")
        frames = page.locator("[data-frame] .mono")
        expect(frames).to_have_text(["map", "└─ odom", "   └─ base", "      └─ laser"])
        expect(page.locator(".frames")).to_contain_text("(by /robot_frames)")
