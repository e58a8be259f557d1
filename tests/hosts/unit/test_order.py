"""Orders: paths of the operator's machine become references, which a host resolves."""

from __future__ import annotations

import json
import os
import re
import signal
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.base.errors import ExecutableNotFoundError, LaunchFileError
from launcher.base.model.record import replace
from launcher.base.model.spec import (
    Limits,
    ProcessSpec,
    RestartMode,
    RestartPolicy,
    RosIdentity,
    StopPolicy,
)
from launcher.hosts.file import order_json
from launcher.hosts.file.order import (
    ExecutableReference,
    Inherited,
    InterpreterReference,
    Order,
    SentFile,
    SharedFile,
    order_for,
)
from launcher.hosts.file.order_words import as_words, files_of
from launcher.hosts.file.resolution import resolve
from launcher.packages.source_packages import MARKERS

SYSTEM = {"PATH": "/usr/bin:/bin", "HOME": "/home/operator"}


def make_prefix(root: Path) -> dict[str, str]:
    """A prefix with the package `demo`; the environment of an operator who has sourced it."""
    prefix = root / "prefix"
    for file in (f"{MARKERS}/demo", "share/demo/package.xml", "share/demo/config/a b.yaml"):
        (prefix / file).parent.mkdir(parents=True, exist_ok=True)
        (prefix / file).write_text("x: 1\n")
    program = prefix / "lib/demo/talker"
    program.parent.mkdir(parents=True)
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    return {**SYSTEM, "AMENT_PREFIX_PATH": str(prefix)}


@pytest.fixture
def env(tmp_path) -> dict[str, str]:
    return make_prefix(tmp_path)


def spec(*argv: str, env: Mapping[str, str], **more: object) -> ProcessSpec:
    return ProcessSpec(name="talker-1", label="talker", argv=argv, env=env, **more)


def order(*argv: str, env: Mapping[str, str], **more: object) -> Order:
    return order_for(spec(*argv, env=env, **more), base=env)


def warnings(*argv: str, env: Mapping[str, str], **more: object) -> list[str]:
    said: list[str] = []
    order_for(spec(*argv, env=env, **more), base=env, warn=said.append)
    return said


def share(env: Mapping[str, str]) -> str:
    return f"{env['AMENT_PREFIX_PATH']}/share/demo"


# ---- words


def test_the_executable_of_a_node_is_a_reference_behind_its_prefix(env):
    program = f"{env['AMENT_PREFIX_PATH']}/lib/demo/talker"
    ros = RosIdentity(package="demo", executable="talker")

    found = order("gdb", "--args", program, "--ros-args", env=env, ros=ros)

    assert found.words == (
        ("gdb",),
        ("--args",),
        (ExecutableReference("demo", "talker"),),
        ("--ros-args",),
    )
    assert found.executables == (ExecutableReference("demo", "talker"),)


def test_an_executable_that_is_named_by_its_path_is_a_reference(env):
    found = order(f"{env['AMENT_PREFIX_PATH']}/lib/demo/talker", env=env)

    assert found.words == ((ExecutableReference("demo", "talker"),),)


def test_python_is_that_of_the_host():
    assert order(sys.executable, "-m", "demo", env=SYSTEM).words[0] == (InterpreterReference(),)


def test_files_in_share_are_references_in_every_form(env):
    path = f"{share(env)}/config/a b.yaml"
    reference = SharedFile("demo", "config/a b.yaml")

    found = order("x", path, f"file:={path}", f"--file={path}", share(env), env=env)

    assert found.words[1:] == (
        (reference,),
        ("file:=", reference),
        ("--file=", reference),
        (SharedFile("demo", ""),),
    )
    assert found.files == {}


def test_packages_of_a_workspace_and_of_source_folders_are_found(tmp_path, monkeypatch):
    built = tmp_path / "install/demo"
    source = tmp_path / "src/own_demo"
    for file in (built / MARKERS / "demo", built / "lib/demo/talker", built / "share/demo/a.yaml"):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch(mode=0o755)
    (source / "config").mkdir(parents=True)
    (source / "config/b.yaml").touch()
    (source / "CMakeLists.txt").touch()
    (source / "package.xml").write_text("<package><name>own_demo</name></package>")
    monkeypatch.chdir(source)
    words = (
        built / "lib/demo/talker",
        built / "share/demo/a.yaml",
        source / "config/b.yaml",
        source,
    )

    found = order(*map(str, words), env=SYSTEM)

    assert found.words == (
        (ExecutableReference("demo", "talker"),),
        (SharedFile("demo", "a.yaml"),),
        (SharedFile("own_demo", "config/b.yaml"),),
        (SharedFile("own_demo", ""),),
    )


def test_a_file_that_exists_only_here_is_sent(env, tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "p.yaml").write_text("one")
    (tmp_path / "a/p.yaml").write_text("two")

    found = order(
        "x", "--params-file", "p.yaml", f"{tmp_path}/a/p.yaml", env=env, cwd=str(tmp_path)
    )

    assert found.words[2:] == ((SentFile("p.yaml"),), (SentFile("p-2.yaml"),))
    assert found.files == {"p.yaml": b"one", "p-2.yaml": b"two"}


def test_paths_in_a_parameter_file_lead_to_the_share_folder_there(env, tmp_path):
    path = f"{share(env)}/package.xml"
    (tmp_path / "params").write_text(f"/**: {{ros__parameters: {{map: {path}, n: 1}}}}\n")
    sent = order("x", f"{tmp_path}/params", env=env)
    other = make_prefix(tmp_path / "host")

    resolve(sent, str(tmp_path / "folder"), other)

    assert path.encode() not in sent.files["params"]
    assert sent.shared_files == (SharedFile("demo", "package.xml"),)
    text = (tmp_path / "folder/params").read_text()
    assert text == f"/**: {{ros__parameters: {{map: {share(other)}/package.xml, n: 1}}}}\n"
    assert (tmp_path / "folder/params").stat().st_mode & 0o777 == 0o600


def test_a_script_is_sent_behind_its_interpreter(env, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, line in {"a.py": "#!/usr/bin/env python3", "b.sh": "#!/bin/bash -e"}.items():
        (tmp_path / name).write_text(f"{line}\n")
        (tmp_path / name).chmod(0o755)

    assert order("./a.py", "-v", env=env).words == (
        (InterpreterReference(),),
        (SentFile("a.py"),),
        ("-v",),
    )
    assert order("./b.sh", env=env).words == (("/bin/bash",), ("-e",), (SentFile("b.sh"),))


def test_a_program_of_the_python_environment_is_found_by_its_name():
    script = Path(sys.prefix, "bin/pip")

    assert order(str(script), env=SYSTEM).words == (("pip",),)


def test_system_paths_stay():
    assert order("/usr/bin/env", "/etc/hostname", "/dev/null", env=SYSTEM).words == (
        ("/usr/bin/env",),
        ("/etc/hostname",),
        ("/dev/null",),
    )


def test_a_large_file_is_an_error_with_the_place_in_the_launch_file(env, tmp_path):
    (tmp_path / "map.pgm").write_bytes(b"0" * (2 * 1024**2))

    with pytest.raises(LaunchFileError, match="more than 1 MiB are not sent") as caught:
        order("x", f"{tmp_path}/map.pgm", env=env, place="demo.launch.py:7")

    assert caught.value.where == "demo.launch.py:7"


def test_what_may_not_work_there_is_told_with_its_place(env, tmp_path):
    (tmp_path / "tool").write_bytes(b"\x7fELF")
    folder, place = str(tmp_path), "demo.launch.py:7"

    assert warnings(f"{folder}/tool", env=env, place=place) == [
        f"{place}: talker-1: the program is not sent, and must be there at the same path: "
        f"{folder}/tool"
    ]
    assert warnings("x", folder, env=env, cwd=folder) == [
        f"the launch file: talker-1: the folder is not sent, and must be there at the same path: "
        f"{folder}",
        f"the launch file: talker-1: the working directory must be there at the same path: "
        f"{folder}",
    ]
    assert warnings(f"cat {folder}/tool | wc", env=env, shell=True) == [
        f"the launch file: talker-1: the shell command has a path of this machine: {folder}/tool"
    ]


# ---- the environment


def test_variables_of_ros_and_of_the_launch_file_are_sent_and_those_of_the_machine_are_not(env):
    base = {**env, "ROS_DOMAIN_ID": "7", "ROS_DISTRO": "jazzy", "EDITOR": "vi", "GONE": "1"}
    given = {key: value for key, value in base.items() if key != "GONE"} | {"LEVEL": "3"}

    found = order_for(spec("x", env=given), base=base, environment={"TOKEN": "s3cret"})

    assert found.environment == {"ROS_DOMAIN_ID": "7", "LEVEL": "3", "TOKEN": "s3cret"}
    assert found.unset == ("GONE",)


def test_an_extended_search_path_extends_that_of_the_host(env):
    given = {**env, "PATH": f"/opt/tool:{env['PATH']}", "MODELS": f"/m:{share(env)}/models"}
    (Path(share(env)) / "models").mkdir()

    found = order_for(spec("x", env=given), base=env)

    assert found.variables == {
        "PATH": ("/opt/tool:", Inherited("PATH")),
        "MODELS": ("/m:", SharedFile("demo", "models")),
    }
    assert resolve(found, "/none", {**env, "PATH": "/bin"}).env["PATH"] == "/opt/tool:/bin"


def test_a_profile_of_the_middleware_is_sent(env, tmp_path):
    (tmp_path / "dds.xml").write_text("<dds/>")
    base = {**env, "FASTRTPS_DEFAULT_PROFILES_FILE": f"{tmp_path}/dds.xml"}
    base["CYCLONEDDS_URI"] = f"file://{tmp_path}/dds.xml"

    found = order_for(spec("x", env=base), base=base)

    assert found.variables == {
        "FASTRTPS_DEFAULT_PROFILES_FILE": (SentFile("dds.xml"),),
        "CYCLONEDDS_URI": ("file://", SentFile("dds.xml")),
    }


def test_secrets_are_not_in_the_text_of_an_order(env, tmp_path):
    found = order_for(spec("x", env=env), base=env, environment={"TOKEN": "s3cret"})
    resolved = resolve(found, str(tmp_path), env)

    assert (
        "s3cret" not in f"{found!r} {resolved!r} {found} {as_words(found, python='p', folder='f')}"
    )


# ---- on a host


def test_the_host_says_what_it_does_not_have(env, tmp_path):
    found = order("x", env=env, ros=RosIdentity(package="demo", executable="listener"))

    with pytest.raises(ExecutableNotFoundError):
        resolve(found, str(tmp_path), env)


def test_a_node_is_run_by_launcher_run_where_no_agent_is(env, tmp_path):
    (tmp_path / "p.yaml").write_text("one")
    ros = RosIdentity(package="demo", executable="talker")
    found = order("talker", "--params-file", f"{tmp_path}/p.yaml", env=env, ros=ros)

    words = as_words(found, python="/v/bin/python", folder="/run/x")

    assert words == (
        *("/v/bin/python", "-m", "launcher", "run", "demo", "talker"),
        *("--params-file", "/run/x/p.yaml"),
    )
    assert files_of(found) == {"p.yaml": b"one"}


@pytest.mark.parametrize("shell", [False, True])
def test_paths_that_only_the_host_knows_are_resolved_there(env, tmp_path, shell):
    path = f"{share(env)}/package.xml"
    words = (f"cat {path}",) if shell else ("/bin/cat", path)
    found = order(*words, env=env, shell=shell)
    for name, content in files_of(found).items():
        (tmp_path / name).write_bytes(content)

    read, write = os.pipe()
    words = as_words(found, python=sys.executable, folder=str(tmp_path))
    actions = [(os.POSIX_SPAWN_DUP2, write, 1)]
    pid = os.posix_spawn(words[0], words, {**os.environ, **env}, file_actions=actions)
    os.close(write)

    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0
    with open(read, "rb") as output:
        assert output.read() == b"x: 1\n"


def test_orders_as_json_keep_their_policies():
    found = replace(
        order("x\udcff", env=SYSTEM),
        restart=RestartPolicy(mode=RestartMode.ON_FAILURE, backoff_max_s=8.0),
        stop=StopPolicy(polite=((signal.SIGTERM, 2.5),)),
        limits=Limits(nice=5, cpus=(0, 1), rlimits=(("nofile", 10, 20),)),
        files={"a": b"\x00\xff"},
        cwd_in_share=SharedFile("demo", ""),
    )

    assert order_json.decode(json.loads(json.dumps(order_json.encode(found)))) == found


@pytest.mark.parametrize(
    "document", [{}, {"name": 1}, {**order_json.encode(order("x", env={})), "words": 3}]
)
def test_other_json_is_not_an_order(document):
    with pytest.raises(ValueError, match="not an order"):
        order_json.decode(document)


# ---- any order, on the machine where it was made

PATHS = ("{share}/config/a b.yaml", "{share}", "{local}/p.yaml", "{local}/none", "/etc/hostname")
PATHS += ("{local}", sys.executable, "/bin/sh", "{lib}/talker", "relative.yaml", "{local}/data.bin")
FORMS = ("{}", "x:={}", "--opt={}", "a,{},b", "file://{}", "-D{}", "{} {}", "{}:{}", "'{}'")
TEXT = st.text(st.characters(exclude_characters="\0", exclude_categories=("Cs",)), max_size=8)
WORD = (
    st.builds(
        lambda form, path: form.replace("{}", path), st.sampled_from(FORMS), st.sampled_from(PATHS)
    )
    | TEXT
)


@given(
    words=st.lists(WORD, min_size=1, max_size=5),
    values=st.dictionaries(st.from_regex(r"[A-Z]{1,6}", fullmatch=True), WORD, max_size=3),
    shell=st.booleans(),
)
def test_an_order_means_the_same_on_the_machine_where_it_was_made(words, values, shell):
    with tempfile.TemporaryDirectory() as root:
        base = make_prefix(Path(root))
        (Path(root) / "p.yaml").write_text(f"file: {share(base)}/package.xml\n")
        (Path(root) / "data.bin").write_bytes(bytes(range(256)))
        names = {"{share}": share(base), "{local}": root}
        names["{lib}"] = f"{base['AMENT_PREFIX_PATH']}/lib/demo"
        pattern = re.compile("|".join(map(re.escape, names)))
        words = [pattern.sub(lambda found: names[found[0]], word) for word in words]
        given_env = base | {k: pattern.sub(lambda m: names[m[0]], v) for k, v in values.items()}
        made = order_for(spec(*words, env=given_env, shell=shell), base=base)
        sent = order_json.decode(json.loads(json.dumps(order_json.encode(made))))

        folder = f"{root}/folder"
        found = resolve(sent, folder, base)

        assert sent == made
        assert [meant(word, folder, root) for word in found.argv] == words
        for name in values.keys() - {"PATH"}:
            assert meant(found.env[name], folder, root) == given_env[name]


def meant(word: str, folder: str, root: str) -> str:
    """The word with the path of the operator's file in place of that of its copy."""
    head, found, name = word.partition(f"{folder}/")
    if not found:
        return word
    assert Path(folder, name).read_bytes() == Path(root, name).read_bytes()
    return f"{head}{root}/{name}"
