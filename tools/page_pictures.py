"""Make the screenshots of the page: `python -m tools.page_pictures docs/assets/page [NAME...]`.

Starts the fleet, a launch file whose processes fail, and a warehouse of 50 robots, one after the
other, each in a separate domain, opens their pages in Chromium and looks at them.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from playwright.sync_api import Browser, Page, expect

from launcher.posix.domain_lease import leased_domain
from tests.support.browser import chromium
from tests.support.controlled_run import ControlledRun
from tests.support.web_page import run_with_page
from tools.palette_png import packed

FLEET = ("enable_debug:=true", "enable_qos_probe:=true")
ROBOTS = 50
SCREEN = (1280, 800)
PHONE = (400, 800)
PLOTS = "&plot=/battery:data.robot_1.percent&plot=/battery:data.robot_2.percent"

BATTERY = """
import json, time
import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node("battery")
publisher = node.create_publisher(String, "/battery", 10)
start = time.monotonic()
while True:
    t = time.monotonic() - start
    robots = {
        "robot_1": {"percent": round(92 - t * 0.31 + 1.6 * (int(t) % 3), 2)},
        "robot_2": {"percent": round(74 + 9 * abs((t / 11) % 2 - 1), 2)},
    }
    publisher.publish(String(data=json.dumps(robots)))
    time.sleep(0.2)
"""

CRASH = {
    "crash.launch.py": """
from launch import LaunchDescription
from launch.actions import ExecuteProcess


def program(name, **options):
    command = ["python3", "-u", name + ".py"]
    return ExecuteProcess(cmd=command, name=name, cwd=FOLDER, output="screen", **options)


def generate_launch_description():
    names = ["localizer", "camera_driver", "calibrate", "planner", "teleop"]
    lidar = program("lidar", respawn=True, respawn_delay=4.0)
    return LaunchDescription([lidar, *(program(name) for name in names)])
""",
    "localizer.py": """
import json, time


def load(text):
    return json.loads(text)


def configure():
    return load('{"frame": map}')


print("map loaded, 4000 x 4000 cells")
time.sleep(2)
configure()
""",
    "lidar.py": """
import sys, time
print("connecting to /dev/ttyUSB0")
time.sleep(0.5)
sys.exit("[ERROR] [lidar]: cannot open /dev/ttyUSB0: no such device")
""",
    "camera_driver.py": """
import os, signal, time
print("loading kernels")
time.sleep(3)
os.kill(os.getpid(), signal.SIGSEGV)
""",
    "calibrate.py": "print('calibration written')",
    "planner.py": """
import itertools, time
for cycle in itertools.count(1):
    print(f"cycle {cycle}: 14 paths, best costs {3.2 + cycle % 5 / 10:.1f}")
    time.sleep(0.7)
""",
    "teleop.py": "import time\nprint('waiting for a joystick')\ntime.sleep(1000)",
}


class Studio:
    """A browser at a page, and the folder for its pictures."""

    def __init__(self, browser: Browser, link: str, folder: Path) -> None:
        self._browser = browser
        self._link = link
        self._folder = folder

    def look(
        self,
        panel: str,
        size: tuple[int, int] = SCREEN,
        theme: str = "light",
        act: Callable[[Page], None] = lambda page: None,
    ) -> bytes:
        """A picture of a panel, after `act`."""
        width, height = size
        context = self._browser.new_context(
            viewport={"width": width, "height": height},
            color_scheme="dark" if theme == "dark" else "light",
        )
        page = context.new_page()
        page.goto(f"{self._link}#/{panel}")
        page.wait_for_selector(f'[data-shown="{panel.partition("?")[0]}"] > div')
        page.wait_for_timeout(4000)  # rates and lines have come
        act(page)
        picture = page.screenshot()
        context.close()
        return picture

    def save(self, name: str, *pictures: bytes, is_beside: bool = False) -> None:
        """Write pictures, beside or above each other, into one file."""
        page = self._browser.new_page()
        target = self._folder / f"{name}.png"
        target.write_bytes(packed(page, pictures, is_beside=is_beside))
        page.close()
        print(f"wrote {target}: {target.stat().st_size / 1000:.0f} kB")


def fleet(studio: Studio, run: ControlledRun) -> None:
    after = studio.look("processes", (1280, 520), act=lambda page: page.wait_for_timeout(90_000))
    studio.save("processes", after)
    studio.save("log", studio.look("log", (1280, 640)))
    studio.save("graph", studio.look("graph", act=lambda page: page.wait_for_timeout(3000)))
    narrow = [studio.look(name, PHONE, "dark") for name in ("processes", "log", "graph")]
    studio.save("phone", *narrow, is_beside=True)
    run.ask("restart", "robot_2")
    run.ask("kill", "robot_3", signal="SIGKILL")
    run.ask("stop", "debug_logger")
    run.ask("start", "robot_3")
    studio.save("timeline", studio.look("timeline", theme="dark"))
    battery = subprocess.Popen([sys.executable, "-c", BATTERY], env=run.env)
    try:
        studio.save("topics", studio.look(f"topics?topic=/battery{PLOTS}", act=plotted))
    finally:
        battery.kill()
        battery.wait()


def plotted(page: Page) -> None:
    expect(page.locator("[data-last]").first).to_contain_text(".", timeout=20_000)
    page.wait_for_timeout(45_000)


def crash(studio: Studio, run: ControlledRun) -> None:
    log = studio.look("log", (1280, 520), act=first_error)
    run.ask("stop", "teleop")
    processes = studio.look(
        "processes", (1280, 500), act=lambda page: page.wait_for_timeout(20_000)
    )
    studio.save("crash", processes, log)


def first_error(page: Page) -> None:
    page.locator('[data-action="first-error"]').click()
    page.wait_for_timeout(1000)


def warehouse(studio: Studio, run: ControlledRun) -> None:
    studio.save("warehouse", studio.look("processes", act=busy))


def busy(page: Page) -> None:
    """With all robots at work, those with the most CPU first."""
    everything = page.locator('tr[data-process][data-state="RUNNING"]')
    expect(everything).to_have_count(ROBOTS + 2, timeout=120_000)
    page.wait_for_timeout(60_000)
    for _ in range(2):
        page.locator('[data-sort="cpu"]').click()
    page.wait_for_timeout(2000)


# What is started -> its words, what is looked at, and the names of its pictures.
SCENES = {
    "system": (FLEET, fleet, {"processes", "log", "graph", "phone", "timeline", "topics"}),
    "crash": ((), crash, {"crash"}),
    "warehouse": ((f"robots:={ROBOTS}",), warehouse, {"warehouse"}),
}


@contextlib.contextmanager
def running(target: Path | str, words: tuple[str, ...]) -> Iterator[tuple[ControlledRun, str]]:
    with leased_domain() as domain_id, tempfile.TemporaryDirectory(prefix="run-") as folder:
        binaries = str(Path(sys.executable).parent)
        env = {
            **os.environ,
            "PATH": f"{binaries}{os.pathsep}{os.environ['PATH']}",
            "ROS_DOMAIN_ID": str(domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": f"{folder}/log",
        }
        screen = Path(folder, "screen")
        with run_with_page(target, words, env, Path(folder), screen) as (run, link):
            yield run, link
            run.process.send_signal(signal.SIGINT)
            run.process.wait(60)


def write_crash(folder: Path) -> Path:
    for name, text in CRASH.items():
        text = text.replace("FOLDER", repr(str(folder)))
        (folder / name).write_text(text.lstrip(), encoding="utf-8")
    return folder / "crash.launch.py"


def main(folder: str, *names: str) -> int:
    """Write the pictures into `folder`: all, or those of the scenes that have these names."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    with chromium() as browser, tempfile.TemporaryDirectory() as programs:
        for target, (words, scene, pictures) in SCENES.items():
            if names and not pictures.intersection(names):
                continue
            path = write_crash(Path(programs)) if target == "crash" else target
            with running(path, words) as (run, link):
                scene(Studio(browser, link, Path(folder)), run)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
