"""Publishing and echoing types of a workspace, against types of std_msgs with the same fields.

Both run in the environment of the workspace. A publisher sends 10000 messages, RELIABLE, 2500 a
second; its CPU time and that of `topic echo` count, of the start of the programs as well.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from benchmarks.harness import Row, interleaved, median, ratio
from benchmarks.ros.verbs import Cost, cost_of, ros_domain
from launcher.packages.environment import environment
from launcher.packages.workspace import Workspace

MESSAGES, RATE_HZ = 10000, 2500
LISTEN_S = "9"
PACKAGE = "benchmark_interfaces"
# own type -> its definition, the type of std_msgs with the same fields, and the data that is sent
PAIRS = {
    "Text": ("string data", "String", "'x' * 100"),
    "Numbers": (
        "std_msgs/MultiArrayLayout layout\nfloat64[] data",
        "Float64MultiArray",
        "[.5] * 100",
    ),
}
MANIFEST = f"""\
<?xml version="1.0"?>
<package format="3">
  <name>{PACKAGE}</name>
  <version>1.0.0</version>
  <description>Types like those of std_msgs</description>
  <maintainer email="benchmarks@example.com">benchmarks</maintainer>
  <license>MIT</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
  <depend>std_msgs</depend>
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export><build_type>ament_cmake</build_type></export>
</package>
"""
CMAKE = f"""\
cmake_minimum_required(VERSION 3.10)
project({PACKAGE})
find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
find_package(std_msgs REQUIRED)
rosidl_generate_interfaces(${{PROJECT_NAME}} {" ".join(f"msg/{name}.msg" for name in PAIRS)}
  DEPENDENCIES std_msgs)
ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""
PUBLISHER = f"""
import importlib, sys, time, rclpy
from rclpy.qos import QoSProfile
package, name, data = sys.argv[1:]
kind = getattr(importlib.import_module(package + ".msg"), name)
rclpy.init()
node = rclpy.create_node("fast")
publisher = node.create_publisher(kind, "fast", QoSProfile(depth={MESSAGES}))
while publisher.get_subscription_count() == 0:
    time.sleep(0.01)
time.sleep(0.5)  # the subscription has to discover the publisher, too
value, start = eval(data), time.monotonic()
for number in range({MESSAGES}):
    publisher.publish(kind(data=value))
    ahead = start + number / {RATE_HZ} - time.monotonic()
    if ahead > 0.002:
        time.sleep(ahead)
time.sleep(1.5)
node.destroy_node()
rclpy.try_shutdown()
"""


def own_types(runs: int) -> list[Row]:
    """CPU time for own types against that for std_msgs, and messages that were lost."""
    with tempfile.TemporaryDirectory() as folder, ros_domain():
        env = _built(Path(folder))
        rows = []
        for own, (_, standard, data) in PAIRS.items():
            measures = {
                package: partial(_stream, env, package, name, data)
                for package, name in ((PACKAGE, own), ("std_msgs", standard))
            }
            rows += _rows(own, interleaved(min(runs, 5), measures))
    return rows


def _built(root: Path) -> dict[str, str]:
    """The environment of a new workspace with the own types."""
    texts = {"package.xml": MANIFEST, "CMakeLists.txt": CMAKE}
    texts |= {f"msg/{name}.msg": definition for name, (definition, _, _) in PAIRS.items()}
    for path, text in texts.items():
        file = root / "src" / PACKAGE / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    subprocess.run([sys.executable, "-m", "launcher", "build", str(root)], check=True)
    return environment(Workspace(str(root), str(root / "install")), os.environ)


def _stream(env: Mapping[str, str], package: str, name: str, data: str) -> tuple[Cost, float]:
    """What `topic echo` cost, and the CPU time of the publisher."""
    before = dict(os.environ)
    os.environ.update(env)
    try:
        words = [sys.executable, "-c", PUBLISHER, package, name, data]
        publisher = subprocess.Popen(words)
        kind = f"{package}/msg/{name}"
        echo = ("topic", "echo", "/fast", kind, "--csv", "-f", "--timeout", LISTEN_S)
        reliable = ("--qos-reliability", "reliable", "--qos-depth", str(MESSAGES))
        cost = cost_of("-m", "launcher", *echo, *reliable)
        _, status, usage = os.wait4(publisher.pid, 0)
        publisher.returncode = os.waitstatus_to_exitcode(status)
    finally:
        os.environ.clear()
        os.environ.update(before)
    return cost, usage.ru_utime + usage.ru_stime


def _rows(own: str, found: dict[str, list[tuple[Cost, float]]]) -> list[Row]:
    standard = PAIRS[own][1]
    echo, publish = (
        {package: [pick(run) for run in runs] for package, runs in found.items()}
        for pick in (lambda run: run[0].cpu_s, lambda run: run[1])
    )
    rows = []
    for what, cpu in (("publish", publish), ("topic echo", echo)):
        ours, theirs = cpu[PACKAGE], cpu["std_msgs"]
        detail = f"own {median(ours):.2f} s, std_msgs/{standard} {median(theirs):.2f} s"
        rows.append(Row(f"{what}, own {own}, CPU", ratio(ours, theirs), "x", 1.1, detail))
    lost = max(MESSAGES - len(cost.out.splitlines()) for cost, _ in found[PACKAGE])
    rows.append(Row(f"topic echo, own {own}, lost", lost, "messages", 0, f"of {MESSAGES}"))
    return rows
