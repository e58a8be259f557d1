"""From a plan to processes: commands without paths of this machine, files, secrets, delays."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from launcher.export.export_model import ExportedSystem
from launcher.export.process_command import Where, words_of
from launcher.hosts.file.hosts_model import Host

Export = Callable[..., ExportedSystem]
THERE = Where(python="PYTHON", folder="/files", scratch="/scratch")


def test_an_executable_of_a_package_is_found_by_the_launcher_there(exported: Export):
    (process,) = exported("node('a', arguments=['--fast'])").processes
    assert words_of(process, THERE) == [
        *("PYTHON", "-m", "launcher", "run", "group_gp1", "robot_1", "--fast"),
        *("--ros-args", "-r", "__node:=a"),
    ]


def test_generated_parameters_become_a_file_of_a_stable_name(exported: Export):
    (process,) = exported("node('a', parameters=[{'x': 1}, {'y': 'z'}])").processes
    assert process.files == {
        "a.params.yaml": b"/**:\n  ros__parameters:\n    x: 1\n",
        "a.params-2.yaml": b'/**:\n  ros__parameters:\n    y: "z"\n',
    }
    assert words_of(process, THERE)[-3:] == [
        "/files/a.params.yaml",
        "--params-file",
        "/files/a.params-2.yaml",
    ]


def test_a_parameter_file_of_this_machine_is_copied(exported: Export, tmp_path: Path):
    (tmp_path / "own.yaml").write_text("/a: {ros__parameters: {x: 1}}\n")
    (process,) = exported(f"node('a', parameters=[{str(tmp_path / 'own.yaml')!r}])").processes
    assert process.files == {"a.own.yaml": b"/a: {ros__parameters: {x: 1}}\n"}


def test_a_path_in_a_copied_file_is_told(exported: Export, tmp_path: Path):
    system = exported(f"node('a', parameters=[{{'map': {str(tmp_path / 'demo.launch.py')!r}}}])")
    assert [gap.text for gap in system.gaps] == [
        f"a parameter file has a path of this machine: {tmp_path / 'demo.launch.py'}"
    ]


def test_what_only_the_host_knows_is_an_order_without_secrets(exported: Export):
    system = exported(
        "node('a', parameters=[{'map': share + '/package.xml', 'other': 1}], "
        "additional_env={'API_TOKEN': 'hush', 'PLAIN': 'x'})",
        before="from ament_index_python.packages import get_package_share_directory\n"
        "share = get_package_share_directory('std_msgs')\n",
    )
    (process,) = system.processes
    assert words_of(process, THERE) == [
        *("PYTHON", "-m", "launcher.hosts.file.run_order", "/files/a.order.json", "/scratch")
    ]
    assert b"hush" not in process.files["a.order.json"]
    assert process.private == ("API_TOKEN",)
    assert process.environment["PLAIN"] == "x"


def test_variables_of_hosts_are_private_except_settings_of_ros(exported: Export):
    variables = {"FLEET": "secret", "ROS_DOMAIN_ID": "7", "RMW_TOKEN": "secret"}
    host = Host(name="bot", address="10.0.0.2", environment=variables)
    (process,) = exported("node('a')", host_of=lambda spec: host).processes
    assert process.environment["ROS_DOMAIN_ID"] == "7"
    assert process.private == ("FLEET", "RMW_TOKEN")
    assert "secret" not in repr(process.environment)


def test_a_timer_delays_the_start(exported: Export):
    system = exported("node('a'), TimerAction(period=2.5, actions=[node('b')])")
    assert [(one.unit, one.delay_s) for one in system.processes] == [("a", 0.0), ("b", 2.5)]


def test_the_operators_own_variables_and_paths_are_not_exported(exported: Export, monkeypatch):
    monkeypatch.setenv("OPERATORS_OWN", "x")
    monkeypatch.setenv("HOME", "/home/operator")
    (process,) = exported("node('a')").processes
    assert "OPERATORS_OWN" not in process.environment
    assert "/home/operator" not in repr(process)
