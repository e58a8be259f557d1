"""The README that goes with what is exported."""

from __future__ import annotations

import re

import pytest

from launcher.export.export_settings import ExportSettings, export
from launcher.export.verbs.export import ENGINES
from tests.export.unit.conftest import Export, first_on_bot, manifests


@pytest.mark.parametrize("engine", ENGINES)
def test_the_readme_sets_up_what_its_commands_use(exported: Export, engine: str):
    system = exported("node('a'), node('b')", host_of=first_on_bot)
    text = export(engine, system, ExportSettings()).files["README.md"]
    steps = {
        "systemd": (
            "editor bot1/demo.env\n",
            "must be installed",
            "install -D",
            "systemctl enable",
        ),
        "kubernetes": (
            "podman build",
            "kubectl create secret",
            "podman secret create",
            "kubectl apply",
            "do podman kube play",
        ),
        "compose": ("podman build", "editor bot1.env\n", "up --detach"),
        "podman": ("podman build", "editor bot1/demo.env\n", "install -D", "systemctl enable"),
    }[engine]
    places = [text.index(step) for step in steps]
    assert places == sorted(places)


def test_the_readme_calls_the_machine_of_no_host_local(exported: Export):
    system = exported("node('a'), node('b')", host_of=first_on_bot)
    text = export("systemd", system, ExportSettings()).files["README.md"]
    assert "| `b` | local | at once |\n" in text
    assert "\n`local` is the machine that is none of the hosts of the hosts file.\n" in text
    assert "`.venv/bin/python` on bot1, `python3` on local.\n" in text
    assert re.findall("^## On .*", text, re.MULTILINE) == ["## On bot1", "## On local"]


def test_in_a_cluster_processes_of_no_host_run_anywhere(exported: Export):
    system = exported("node('a'), node('b')", host_of=first_on_bot)
    output = export("kubernetes", system, ExportSettings())
    assert "In a cluster its processes run on any node.\n" in output.files["README.md"]
    (found,) = manifests(output, "b")
    assert "nodeSelector" not in found["spec"]["template"]["spec"]


def test_the_readme_names_no_machine_if_there_is_only_one(exported: Export):
    text = export("systemd", exported("node('a')"), ExportSettings()).files["README.md"]
    assert "for `python3` on the machine.\n" in text
    assert "local" not in text


def test_the_readme_has_the_commands(exported: Export):
    system = exported("node('a'), TimerAction(period=1.0, actions=[node('b')])")
    text = export("systemd", system, ExportSettings()).files["README.md"]
    assert "systemctl enable a.service b.timer demo.target\nsystemctl start demo.target\n" in text
    text = export("kubernetes", system, ExportSettings()).files["README.md"]
    assert "kubectl logs -f deploy/a\n" in text


def test_the_readme_starts_each_profile(exported: Export):
    system = exported("node('a'), node('b')", host_of=first_on_bot)
    text = export("compose", system, ExportSettings()).files["README.md"]
    assert re.findall(r"^docker compose (.*) up --detach$", text, re.MULTILINE) == [
        "--profile bot1",
        "--profile local",
    ]
    assert "docker compose --profile local logs -f b\n" in text
