"""What each engine gets, as text; tests/hosts/lab run it."""

from __future__ import annotations

import base64
import json
import re
import signal
import subprocess
from typing import Any

import pytest
import yaml

from launcher.base.model.record import replace
from launcher.base.model.run_options import RunOptions
from launcher.base.model.spec import Limits, RestartMode, RestartPolicy, StopPolicy
from launcher.export.export_model import ExportedSystem
from launcher.export.export_settings import ExportSettings, export
from launcher.export.kubernetes import Kubernetes
from launcher.export.verbs.export import ENGINES
from launcher.export.yaml_text import document
from launcher.hosts.file.hosts_model import Host
from launcher.launch.process_options import parse_limit
from tests.export.unit.conftest import BOT, Export, first_on_bot, manifests


def unit_of(system: ExportedSystem, name: str, **settings: Any) -> str:
    return export("systemd", system, ExportSettings(**settings)).files[name]


def lines_of(text: str, key: str) -> list[str]:
    return [line.partition("=")[2] for line in text.splitlines() if line.startswith(f"{key}=")]


def container(system: ExportedSystem, name: str, **settings: Any) -> dict[str, Any]:
    found = manifests(export("kubernetes", system, ExportSettings(**settings)), name)[-1]
    (only,) = found["spec"]["template"]["spec"]["containers"]
    return dict(only)


# ---- systemd


def test_a_service_and_its_target(exported: Export):
    text = unit_of(exported("node('robot_1')"), "robot_1.service", user="robot")
    assert lines_of(text, "User") == ["robot"]
    assert lines_of(text, "KillSignal") == ["SIGINT"]
    assert lines_of(text, "PartOf") == ["demo.target"]
    assert lines_of(text, "WantedBy") == ["demo.target"]
    assert lines_of(text, "ExecStart") == [
        "/usr/bin/env python3 -m launcher run group_gp1 robot_1 --ros-args -r __node:=robot_1"
    ]


def test_a_delayed_process_is_started_by_a_timer(exported: Export):
    system = exported("TimerAction(period=2.5, actions=[node('late')])")
    assert lines_of(unit_of(system, "late.timer"), "OnActiveSec") == ["2500ms"]
    assert lines_of(unit_of(system, "late.timer"), "WantedBy") == ["demo.target"]
    assert lines_of(unit_of(system, "late.service"), "WantedBy") == []


def test_a_host_without_a_python_uses_what_sync_brings(exported: Export):
    host = Host(name="bot1", address="10.0.0.2", workspace="~/ws/")
    system = exported("node('a')", host_of=lambda spec: host)
    files = export("systemd", system, ExportSettings()).files

    (command,) = lines_of(files["bot1/a.service"], "ExecStart")
    assert " ${HOME}/ws/current/bin/python -m launcher run " in command
    assert (
        "On bot1 the launcher and the packages are those that `launcher hosts sync` brings"
        in (files["README.md"])
    )


def test_no_value_of_a_secret_is_on_a_command_line_of_the_readme(exported: Export, tmp_path):
    system = exported("node('a')", host_of=lambda spec: BOT)
    text = export("kubernetes", system, ExportSettings()).files["README.md"]

    (made,) = re.findall(r"^\(umask.*\)(?= &&)", text, re.MULTILINE)
    subprocess.run(["sh", "-c", made], cwd=tmp_path, check=True)

    (file,) = tmp_path.glob("*.env")
    assert f"--from-env-file={file.name}\n" in text and "--from-literal" not in text
    assert (file.read_text(), file.stat().st_mode & 0o777) == ("FLEET_TOKEN=\n", 0o600)


def test_a_secret_of_podman_is_made_of_the_same_file(exported: Export, tmp_path):
    """Podman 4.3 passes on what this prints, which was tried by hand."""
    system = exported("node('a')", host_of=lambda spec: BOT)
    text = export("kubernetes", system, ExportSettings()).files["README.md"]
    (script,) = re.findall(r"^as_json\(\) .*?(?= \| podman secret create a-env)", text, re.M | re.S)
    (tmp_path / "a-environment.env").write_text("FLEET_TOKEN=hu=sh ü\n\n")

    done = subprocess.run(["sh", "-c", script], cwd=tmp_path, check=True, stdout=subprocess.PIPE)

    values = {name: base64.b64decode(value) for name, value in json.loads(done.stdout).items()}
    assert values == {"FLEET_TOKEN": "hu=sh ü".encode()}


def test_a_host_has_its_python_and_its_set_up(exported: Export):
    system = exported("node('a')", host_of=lambda spec: BOT)
    text = unit_of(system, "bot1/a.service")
    (command,) = lines_of(text, "ExecStart")
    assert '. /opt/ros/jazzy/setup.sh && . \\"$$HOME\\"/' in command
    assert " sh ${HOME}/.venv/bin/python -m launcher run " in command
    assert lines_of(text, "EnvironmentFile") == ["/etc/launcher/demo/demo.env"]


@pytest.mark.parametrize("engine", ENGINES)
def test_no_secret_is_written(exported: Export, engine: str):
    system = exported("node('a', additional_env={'API_KEY': 'hush'})", host_of=lambda spec: BOT)
    files = export(engine, system, ExportSettings()).files
    assert "hush" not in "".join(files.values())
    assert "FLEET_TOKEN" in "".join(files.values())


def test_percent_dollar_and_quotes_stay_what_they_are(exported: Export):
    system = exported("ExecuteProcess(cmd=['echo', '100%', '$HOME', \"a'b c\"], name='e')")
    (command,) = lines_of(unit_of(system, "e.service"), "ExecStart")
    assert command == '/usr/bin/env echo "100%%" "$$HOME" "a\'b c"'


# ---- Kubernetes


def test_a_deployment(exported: Export):
    system = exported("node('robot_1', emulate_tty=True)")
    found = container(system, "robot-1", image="fleet:1")
    assert found["image"] == "fleet:1"
    assert found["tty"] is True
    assert found["command"][:6] == ["python3", "-m", "launcher", "run", "group_gp1", "robot_1"]
    assert {"name": "FASTDDS_BUILTIN_TRANSPORTS", "value": "UDPv4"} in found["env"]
    assert found["startupProbe"]["exec"]["command"][-3:] == ["node", "info", "/robot_1"]


def test_shared_memory_instead_of_udp(exported: Export):
    (found,) = manifests(
        Kubernetes(exported("node('a')"), image="x", shared_memory=True).output(), "a"
    )
    spec = found["spec"]["template"]["spec"]
    assert spec["hostIPC"] is True
    assert all(one["name"] != "FASTDDS_BUILTIN_TRANSPORTS" for one in spec["containers"][0]["env"])


def test_parameter_files_are_a_config_map(exported: Export):
    system = exported("node('a', parameters=[{'x': 1}])")
    config, deployment = manifests(export("kubernetes", system, ExportSettings()), "a")
    assert config["data"] == {"a.params.yaml": "/**:\n  ros__parameters:\n    x: 1\n"}
    spec = deployment["spec"]["template"]["spec"]
    assert spec["volumes"] == [{"name": "files", "configMap": {"name": config["metadata"]["name"]}}]
    assert spec["containers"][0]["volumeMounts"][0]["mountPath"] == "/etc/launcher/files"


def test_a_program_without_restart_is_a_pod(exported: Export):
    system = exported("ExecuteProcess(cmd=['echo', '$(HOME)'], name='once')")
    (pod,) = manifests(export("kubernetes", system, ExportSettings()), "once")
    assert pod["kind"] == "Pod"
    assert pod["spec"]["restartPolicy"] == "Never"
    assert pod["spec"]["shareProcessNamespace"] is True


DOLLARS = "echo $$ $(GREETING) $$(date) $(date) ${X:-y} 100%"


def test_kubernetes_replaces_nothing_in_commands_and_values(exported: Export):
    cmd = f"cmd=['sh', '-c', '{DOLLARS}'], additional_env={{'GREETING': 'a$$b ${{c}} $(d)'}}"
    system = exported(f"ExecuteProcess({cmd}, name='e', respawn=True)")
    found = container(system, "e")
    assert found["command"][2] == "echo $$$$ $$(GREETING) $$$$(date) $(date) ${X:-y} 100%"
    assert {"name": "GREETING", "value": "a$$$$b ${c} $(d)"} in found["env"]
    (gap,) = (one for one in Kubernetes(system, image="x").output().gaps if one.what == "dollars")
    assert gap.is_note


@pytest.mark.parametrize(
    ("variables", "settings", "is_told"),
    [
        ("{'A': '$(B)', 'B': 'x'}", {}, False),  # it refers to none before it
        ("{'B': 'x', 'C': '$(B)'}", {}, True),
        ("{'A': '$(FASTDDS_BUILTIN_TRANSPORTS)'}", {}, True),
        ("{'A': '$(FASTDDS_BUILTIN_TRANSPORTS)'}", {"shared_memory": True}, False),
    ],
)
def test_the_note_names_processes_whose_manifest_has_an_escape(
    exported: Export, variables: str, settings: dict[str, Any], is_told: bool
):
    system = exported(f"node('a', additional_env={variables})")
    output = Kubernetes(system, image="x", **settings).output()
    assert ("$$" in output.files["manifests/a.yaml"]) == is_told
    assert any(gap.what == "dollars" for gap in output.gaps) == is_told


def test_the_words_before_a_command_stay_what_they_are(exported: Export):
    node = "ExecuteProcess(cmd=['echo', '$$'], name='e', respawn=True)"
    limits = Limits(nice=5, cpus=(0,), rlimits=(("nofile", 256, 256),))
    system = exported(
        f"TimerAction(period=2.0, actions=[{node}])",
        options=RunOptions(limits=(("*", limits),)),
    )
    command = container(system, "e")["command"]
    assert command[2] == "trap 'exit 0' INT TERM; sleep 2 & wait $! && exec \"$@\""
    assert command[-2:] == ["echo", "$$$$"]


def test_where_a_pod_runs(exported: Export):
    labelled = replace(BOT, node_selector={"role": "robot"})
    for host, selector in (
        (BOT, {"kubernetes.io/hostname": "bot1"}),
        (labelled, {"role": "robot"}),
    ):
        system = exported("node('a')", host_of=lambda spec, host=host: host)
        (found,) = manifests(export("kubernetes", system, ExportSettings()), "a")
        assert found["spec"]["template"]["spec"]["nodeSelector"] == selector


def test_private_variables_come_from_a_secret(exported: Export):
    found = container(exported("node('a')", host_of=lambda spec: BOT), "a")
    reference = {"name": "a-environment", "key": "FLEET_TOKEN"}
    assert {"name": "FLEET_TOKEN", "valueFrom": {"secretKeyRef": reference}} in found["env"]


LIMITS = Limits(nice=5, cpus=(0, 2), rlimits=(("nofile", 256, 512), ("as", 2**30, -1)))


def test_limits_in_containers(exported: Export):
    system = exported("node('a')", options=RunOptions(limits=(("*", LIMITS),)))
    found = container(system, "a")
    assert found["command"][:9] == [
        *("nice", "-n", "5", "taskset", "-c", "0,2"),
        *("prlimit", "--nofile=256:512", "--as=1073741824:unlimited"),
    ]
    assert found["resources"]["limits"] == {"cpu": "2", "memory": "1073741824"}
    assert found["resources"]["requests"] == {"cpu": "0", "memory": "0"}
    (service,) = compose(system).values()
    assert service["cpuset"] == "0,2"
    assert service["ulimits"] == {"nofile": {"soft": 256, "hard": 512}}
    assert service["command"][:4] == ["nice", "-n", "5", "prlimit"]
    assert parse_limit("a:nofile=256")[1].rlimits[0][0] == "nofile"


@pytest.mark.parametrize(
    ("variables", "settings", "is_told"),
    [
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, ExportSettings(), True),
        ({"ROS_LOCALHOST_ONLY": "1"}, ExportSettings(), True),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, ExportSettings(shared_memory=True), False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, ExportSettings(), False),
    ],
)
def test_a_range_that_loses_all_messages_is_told(
    exported: Export, variables: dict[str, str], settings: ExportSettings, is_told: bool
):
    host = Host(name="bot", address="10.0.0.2", environment=variables)
    output = export("compose", exported("node('a')", host_of=lambda spec: host), settings)
    assert any("lose all messages" in gap.text for gap in output.gaps) is is_told


# ---- Compose and Quadlet


def compose(system: ExportedSystem, **settings: Any) -> dict[str, Any]:
    document = yaml.safe_load(
        export("compose", system, ExportSettings(**settings)).files["compose.yaml"]
    )
    return dict(document["services"])


def test_services_of_a_host_have_its_profile(exported: Export):
    services = compose(exported("node('a'), node('b')", host_of=first_on_bot))
    assert services["a"]["profiles"] == ["bot1"]
    assert services["b"]["profiles"] == ["local"]
    assert services["a"]["env_file"] == ["bot1.env"]
    assert services["b"]["network_mode"] == "host"
    assert services["b"]["stop_signal"] == "SIGINT"


def test_compose_has_no_profiles_without_hosts(exported: Export):
    system = exported("node('a')")
    assert "profiles" not in compose(system)["a"]
    assert "--profile" not in export("compose", system, ExportSettings()).files["README.md"]


def test_compose_variables_are_not_replaced(exported: Export):
    services = compose(exported("ExecuteProcess(cmd=['echo', '$HOME'], name='e')"))
    assert services["e"]["command"] == ["echo", "$$HOME"]
    assert services["e"]["init"] is True


@pytest.mark.parametrize(
    ("policy", "expected"),
    [
        (RestartPolicy(), "no"),
        (RestartPolicy(mode=RestartMode.ALWAYS), "always"),
        (RestartPolicy(mode=RestartMode.ON_FAILURE), "on-failure"),
        (RestartPolicy(mode=RestartMode.ON_FAILURE, max_restarts=3), "on-failure:3"),
    ],
)
def test_restart_policies_of_compose(exported: Export, policy: RestartPolicy, expected: str):
    system = exported("node('a')", options=RunOptions(restart=(("*", policy),)))
    assert compose(system)["a"]["restart"] == expected


def test_a_quadlet_file_and_its_timer(exported: Export):
    system = exported("node('a'), TimerAction(period=1.0, actions=[node('b')])")
    files = export("podman", system, ExportSettings()).files
    text = files["a.container"]
    assert lines_of(text, "ContainerName") == ["a"]
    assert lines_of(text, "Network") == ["host"]
    assert lines_of(text, "WantedBy") == ["demo.target"]
    assert "b.timer" in files
    assert lines_of(files["b.container"], "WantedBy") == []


# ---- what is lost


ALWAYS = RestartPolicy(mode=RestartMode.ALWAYS)
LIMITED, LATER = replace(ALWAYS, max_restarts=3), replace(ALWAYS, delay_s=2.0)
GROWING = replace(ALWAYS, delay_s=1.0, backoff_max_s=30.0)
BY_SIGTERM = StopPolicy(polite=((signal.SIGTERM, 2.0),))


@pytest.mark.parametrize(
    ("engine", "change", "what"),
    [
        ("kubernetes", {"restart": LIMITED}, "restart limit"),
        ("compose", {"restart": LIMITED}, "restart limit"),
        ("kubernetes", {"restart": LATER}, "restart delay"),
        ("compose", {"restart": LATER}, "restart delay"),
        ("systemd", {"restart": GROWING}, "restart"),
        ("podman", {"restart": GROWING}, "restart"),
        ("kubernetes", {}, "no restart"),
        ("kubernetes", {"stop": BY_SIGTERM}, "stop"),
        ("kubernetes", {"limits": Limits(nice=-5)}, "nice"),
        ("systemd", {}, "user"),
    ],
)
def test_what_an_engine_cannot_do_is_told(
    exported: Export, engine: str, change: dict[str, Any], what: str
):
    policies = {name: (("*", policy),) for name, policy in change.items()}
    system = exported("node('a')", options=RunOptions(**policies))
    output = export(engine, system, ExportSettings())
    assert what in [gap.what for gap in output.gaps]
    assert re.search(rf"\* demo.launch.py:\d+: {what} \(a\): ", output.files["README.md"])


def test_a_terminal_of_its_own_is_none_in_a_unit(exported: Export):
    output = export("systemd", exported("node('a', emulate_tty=True)"), ExportSettings())
    assert "emulate_tty" in [gap.what for gap in output.gaps]


@pytest.mark.parametrize("text", ["0483", "1e5", "y", "Off", "nan", "0o17", "0x1F", "1_000", ""])
def test_a_value_that_some_reader_takes_for_no_text_has_quotes(text: str):
    assert document({"value": text}) == f"value: '{text}'\n"


def test_other_values_have_none():
    assert document({"kind": "Pod", "path": "/a b:c"}) == "kind: Pod\npath: /a b:c\n"
