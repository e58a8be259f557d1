"""`tf` with a robot that broadcasts its frames, and `tf2_msgs` as `launcher build` makes it."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

from tests.support.json_forms import fit
from tests.support.node_process import line_of
from tests.support.probe_process import ProbeProcess, names
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import Answer, eventually, going_on, launcher
from tests.support.waiting import wait_until
from tests.support.workspaces import TRANSFORM_TYPES, BuiltWorkspace, built_once

Run = Callable[..., Answer]


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> BuiltWorkspace:
    return built_once(tmp_path_factory.getbasetemp(), "transform_types", TRANSFORM_TYPES)


@pytest.fixture(scope="module")
def robot(
    workspace: BuiltWorkspace, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path_factory.mktemp("log")) as env:
        env = workspace.environment(env)
        with talking(env, "tests.support.robot_frames"):
            yield env


@pytest.fixture
def tf(robot: dict[str, str]) -> Run:
    return lambda *words: launcher(robot, "tf", *words)


@pytest.mark.thorough
def test_a_chain_over_moving_and_static_transforms(tf):
    answer = tf("echo", "map", "laser", "--once")

    assert answer.code == 0
    assert answer.lines[0].startswith("At time ")
    assert answer.lines[1:] == [
        "- Translation: [3.500, 0.000, 0.000]",
        "- Rotation: in Quaternion (xyzw) [0.000, 0.000, 0.707, 0.707]",
        "- Rotation: in RPY (radian) [0.000, -0.000, 1.571]",
        "- Rotation: in RPY (degree) [0.000, -0.000, 90.000]",
        "- Matrix:",
        "  0.000 -1.000  0.000  3.500",
        "  1.000  0.000  0.000  0.000",
        "  0.000  0.000  1.000  0.000",
        "  0.000  0.000  0.000  1.000",
    ]


@pytest.mark.thorough
def test_the_tree_names_the_nodes_that_broadcast(tf):
    def tree() -> Answer:
        return tf("tree", "-t", "2", "--json")

    answer = eventually(tree, lambda answer: len(json.loads(answer.out)["frames"]) == 3)

    [document] = fit("tf tree", answer.out)
    found = {one["frame"]: one for one in document["frames"]}
    assert {one: found[one]["parent"] for one in found} == {
        "odom": "map",
        "base": "odom",
        "laser": "base",
    }
    assert {node for one in found.values() for node in one["broadcasters"]} == {"/robot_frames"}
    assert [one["static"] for one in found.values()] == [False, True, False]
    assert found["odom"]["rate_hz"] > 1.0
    assert document["roots"] == ["map"]


@pytest.mark.thorough
def test_the_monitor_measures_the_way_between_two_frames(tf):
    def monitor() -> Answer:
        return tf("monitor", "base", "map", "--for", "3", "--json")

    def has_chain(answer: Answer) -> bool:
        return bool(answer.lines) and bool(json.loads(answer.lines[-1])["net_delay"])

    *_, report = fit("tf monitor", eventually(monitor, has_chain).out)

    assert report["chain"] == ["base", "odom", "map"]
    assert [one["frame"] for one in report["frames"]] == ["base", "odom"]
    assert {one["node"] for one in report["broadcasters"]} == {"/robot_frames"}


@pytest.mark.thorough
def test_a_frame_that_is_not_there(tf):
    answer = tf("echo", "map", "nose", "--timeout", "2")

    assert (answer.code, answer.out) == (1, "")
    assert answer.err.splitlines()[-1].startswith("no transform map -> nose: ")


@pytest.mark.thorough
def test_a_static_publisher_until_it_is_stopped(tf, robot):
    words = ("--x", "-1.5", "--yaw", "0.5", "--frame-id", "laser", "--child-frame-id", "tip")
    command = [sys.executable, "-m", "launcher", "tf", "static", *words]
    with subprocess.Popen(command, env=robot, stderr=subprocess.PIPE, text=True) as publisher:
        try:
            printed = [line_of(publisher.stderr) for _ in range(4)]
            answer = tf("echo", "map", "tip", "--once", "--json")
        finally:
            publisher.send_signal(signal.SIGTERM)
        publisher.communicate(timeout=60)

    assert "Spinning until stopped - publishing transform\n" in printed[0]
    assert printed[1:] == [
        "translation: ('-1.500000', '0.000000', '0.000000')\n",
        "rotation: ('0.000000', '0.000000', '0.247404', '0.968912')\n",
        "from 'laser' to 'tip'\n",
    ]
    assert publisher.returncode == 0
    [found] = fit("tf echo", answer.out)
    assert found["translation"] == pytest.approx([3.5, -1.5, 0.0])


@pytest.mark.thorough
@pytest.mark.parametrize("words", ["echo map laser", "monitor map laser"])
def test_an_interruption_is_the_usual_end(robot, words):
    command = [sys.executable, "-m", "launcher", "tf", *words.split()]
    with subprocess.Popen(command, env=robot, stdout=subprocess.PIPE, text=True) as verb:
        assert line_of(verb.stdout).startswith(("At time ", "Gathering data on map -> laser"))
        verb.send_signal(signal.SIGINT)
        verb.communicate(timeout=60)

    assert verb.returncode == 0


@pytest.mark.thorough
def test_a_recording_of_the_robot(tf, robot, tmp_path):
    bag = tmp_path / "bag"
    with going_on(robot, "bag", "record", "/tf", "/tf_static", "-o", str(bag)):
        for _ in range(2):
            assert tf("echo", "map", "laser", "--once").code == 0  # it goes on meanwhile
    assert bag.is_dir()

    answer = launcher(
        {**robot, "PYTHONPATH": ""}, "tf", "echo", "map", "laser", "--bag", str(bag), "--once"
    )

    assert "- Translation: [3.500, 0.000, 0.000]" in answer.lines
    frames = json.loads(tf("tree", str(bag), "--json").out)["frames"]
    assert [one["frame"] for one in frames] == ["base", "laser", "odom"]


@pytest.mark.thorough
def test_the_probe_has_the_tree_for_pages(robot):
    with ProbeProcess(robot) as probe:
        probe.graph(lambda graph: "/robot_frames" in names(graph), "the robot")
        wait_until(lambda: len(probe.ask("frames")["rows"]) == 4, "all frames")

        answer = probe.ask("frames")

    assert [frame for frame, _ in answer["rows"]] == [
        "map",
        "└─ odom",
        "   └─ base",
        "      └─ laser",
    ]
    assert answer["rows"][3][1] == "static (by /robot_frames)"
    assert answer["problems"] == []


@pytest.mark.thorough
def test_without_the_type_the_error_has_the_commands_that_build_it(tmp_path):
    with ros_domain(tmp_path) as env:
        answer = launcher(env, "tf", "echo", "map", "base", cwd=tmp_path)

    assert answer.code == 1
    assert "tf2_msgs/msg/TFMessage, which is not installed" in answer.err
    assert "sparse-checkout add tf2_msgs && " in answer.err
