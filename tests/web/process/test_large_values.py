"""Parameters that a form of JavaScript could spoil: large integers, and texts of several lines."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from tests.support.browser import page_at
from tests.support.controlled_run import ControlledRun
from tests.web.process.conftest import Start
from tests.web.process.test_fleet_page import show

pytestmark = pytest.mark.browser

NODE = """
import rclpy
from rclpy.node import Node

rclpy.init()
node = Node("wide")
node.declare_parameter("stamps", [1, 2])
node.declare_parameter("script", "one\\ntwo")


def told(parameters):
    from rcl_interfaces.msg import SetParametersResult
    for one in parameters:
        print("got", one.name, repr(one.value), flush=True)
    return SetParametersResult(successful=True)


node.add_on_set_parameters_callback(told)
rclpy.spin(node)
"""
LAUNCH = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess


def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=[sys.executable, {node!r}], name="wide", output="screen"),
    ])
"""


@pytest.fixture
def page(started: Browser, start: Start, tmp_path: Path) -> Iterator[tuple[Page, ControlledRun]]:
    node = tmp_path / "wide.py"
    node.write_text(NODE)
    file = tmp_path / "wide.launch.py"
    file.write_text(LAUNCH.format(node=str(node)))
    run, link = start(file)
    with page_at(started, link, viewport={"width": 1280, "height": 800}) as open_page:
        expect(open_page.locator(".app-link")).to_have_text("open")
        yield open_page, run


def change(page: Page, name: str, text: str) -> Locator:
    parameter = page.locator(f'[data-parameter="{name}"]')
    parameter.locator("input, textarea").first.fill(text)
    parameter.locator('[data-action="set"]').click()
    expect(parameter.locator('[data-field="done"]')).to_be_visible()
    return parameter


def test_values_arrive_as_typed(page: tuple[Page, ControlledRun]):
    shown, run = page
    expect(shown).to_have_title("wide.launch.py - launcher")
    show(shown, "parameters")
    shown.locator('[data-node="/wide"]').click()
    stamps = change(shown, "stamps", "[1, 9007199254740993]")
    run.wait_for("9007199254740993]")
    assert "[1, 9007199254740993]" in run.screen
    expect(stamps.locator("input, textarea").first).to_have_value("[1, 9007199254740993]")

    change(shown, "script", "one\nthree\nfour")
    run.wait_for(r"'one\nthree\nfour'")
