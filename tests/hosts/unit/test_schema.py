"""The reader, the JSON schema and the documentation agree about hosts files."""

from __future__ import annotations

import json

import jsonschema
import pytest
import yaml

from launcher.base.errors import LauncherError
from launcher.hosts.file import hosts_reader
from launcher.hosts.file.host_fields import HOST_FIELDS
from launcher.hosts.file.pattern import PREFIXES
from launcher.hosts.file.schema import json_schema
from tests.support.repository import REPOSITORY, docs_page

SCHEMA = json_schema()
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
GOOD = {
    "addresses": "hosts: {a: 10.0.0.1, b: {address: 'fd00::1'}, c.d: e}",
    "ssh": "hosts: {a: {address: b, ssh: {Port: 22, IdentityFile: ~/.ssh/x, Compression: yes}}}",
    "python": "hosts: {a: {address: b, venv: .venv, ros: /opt/ros/jazzy, setup: ws/setup.sh}}",
    "setup": "hosts: {a: {address: b, setup: [/a.sh, b.sh], python: /usr/bin/python3}}",
    "environment": "hosts: {a: {address: b, environment: {A: 1, B: x, C: true}}}",
    "secrets": "hosts: {a: {address: b, environment: {A: {from_environment: HOME}}}}",
    "keep": "hosts: {a: {address: b, on_link_loss: keep, engine: systemd}}",
    "stop": "hosts: {a: {address: b, on_link_loss: stop-after=10 s, engine: ssh}}",
    "stop in minutes": "hosts: {a: {address: b, on_link_loss: 2 min}}",
    "stop in seconds": "hosts: {a: {address: b, on_link_loss: 7}}",
    "defaults": "defaults: {user: robot, workspace: ws, node_selector: {x: 1}}\nhosts: {a: b}",
    "place": "hosts: {a: b}\nplace: {robot_1: a, /ns/**: a, monitor: local}",
    "empty": "hosts: {a: b}\nplace:\ndefaults:\n",
    "discovery": "hosts: {a: b}\ndiscovery: peers",
    "server": "hosts: {a: b}\ndiscovery: {mode: server, server: a, backup: local, port: 11811}",
}
BAD = (
    "",
    "[]",
    "place: {}",
    "hosts: {}",
    "hosts: {local: a}",
    "hosts: {'a b': c}",
    "hosts: {a: {user: b}}",
    "hosts: {a: {address: b, engine: docker}}",
    "hosts: {a: {address: b, user: 'x y'}}",
    "hosts: {a: {address: b, ssh: {ControlPath: x}}}",
    "hosts: {a: {address: b, ssh: {Port: 0}}}",
    "hosts: {a: {address: b, ssh: {StrictHostKeyChecking: 'no'}}}",
    "hosts: {a: {address: b, python: x, venv: y}}",
    "hosts: {a: {address: b, on_link_loss: never}}",
    "hosts: {a: {address: b, environment: {A: {from: B}}}}",
    "hosts: {a: {address: b, adress: c}}",
    "hosts: {a: b}\nplace: {x: [a, b]}",
    "hosts: {a: b}\ndefaults: {address: c}",
    "hosts: {a: b}\ndiscovery: gossip",
    "hosts: {a: b}\ndiscovery: {server: a}",
)


def fits_schema(text: str) -> bool:
    return bool(VALIDATOR.is_valid(yaml.safe_load(text)))


@pytest.mark.parametrize("name", GOOD)
def test_good_files_are_good_for_both(name: str):
    hosts_reader.parse(GOOD[name], "hosts.yaml", {"HOME": "/"})
    assert fits_schema(GOOD[name])


@pytest.mark.parametrize("text", BAD)
def test_bad_files_are_bad_for_both(text: str):
    with pytest.raises(LauncherError):
        hosts_reader.parse(text, "hosts.yaml", {})
    assert not fits_schema(text)


def test_every_entry_of_a_host_is_in_a_good_file():
    text = " ".join(GOOD.values())
    assert [field.name for field in HOST_FIELDS if f"{field.name}:" not in text] == []


def test_the_schema_in_the_repository_is_the_one_of_the_reader():
    path = REPOSITORY / "launcher" / "hosts" / "hosts.schema.json"
    assert json.loads(path.read_text(encoding="utf-8")) == SCHEMA
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    assert "(?P<" not in str(SCHEMA)  # Python's own, which ECMAScript refuses


def test_the_documentation_has_a_row_for_each_entry_and_each_kind_of_pattern():
    document = docs_page("hosts-file")
    rows = [line for line in document.splitlines() if line.startswith("| `")]
    for field in HOST_FIELDS:
        assert any(f"`{field.name}`" in row.split(" | ")[0] for row in rows), field.name
    for prefix in PREFIXES:
        assert any(f"`{prefix}:" in row.split(" | ")[0] for row in rows), prefix


@pytest.mark.parametrize("page", ["hosts-file", "hosts", "robots"])
def test_the_examples_of_the_documentation_are_good_files(page: str):
    document = docs_page(page)
    examples = [part.split("```")[0] for part in document.split("```yaml\n")[1:]]
    assert examples
    for example in examples:
        hosts_reader.parse(example, "hosts.yaml", {}, with_secrets=False)
        assert fits_schema(example)


def test_the_example_is_a_good_file():
    path = REPOSITORY / "examples" / "hosts.yaml"
    found = hosts_reader.read(str(path), {})
    assert len(found.hosts) == 3
    assert fits_schema(path.read_text(encoding="utf-8"))
    (line,) = [x for x in path.read_text().splitlines() if "$schema=" in x]
    schema = path.parent / line.partition("$schema=")[2]
    assert schema.resolve() == REPOSITORY / "launcher" / "hosts" / "hosts.schema.json"
