"""What the descendants of a process write when it has exited, or runs again."""

from __future__ import annotations

import contextlib
import os
import re
import socket
from pathlib import Path

import pytest

from launcher.base.model.spec import OutputPolicy, ProcessSpec
from launcher.output.logs.run_directory import RunDirectory
from launcher.output.stdout import StdoutWriter
from launcher.posix.reactor import Reactor
from launcher.posix.spawn import BOTH, Child
from launcher.run.compose.group_output import GroupOutput
from launcher.run.output.output_reader import OutputReader
from launcher.run.processes.process import Process
from tests.support.benches import Bench, ControlBench
from tests.support.link_recorder import Recorder, python
from tests.support.waiting import wait_until

# Waits until its file exists, and then writes: if its pipe were closed, it would end by SIGPIPE.
WAITS = "until [ -e {file} ]; do sleep 0.02; done; echo {text}"
ON_IO = "__import__('launch.event_handlers').event_handlers.OnProcessIO"


def _left(folder: Path, *texts: str) -> str:
    """Commands of a shell that leave a child which writes each text when its file is there."""
    waits = [WAITS.format(file=folder / text, text=text) for text in texts]
    return f"({'; '.join(waits)}; touch {folder}/done) & "


def _log(bench: Bench, name: str = "launch.log") -> str:
    return (bench.folder / "log/latest" / name).read_text()


@pytest.mark.parametrize("tty", [False, True], ids=["pipe", "pseudo-terminal"])
def test_a_child_that_outlives_its_process_is_read_to_the_end(bench: Bench, tty: bool):
    script = _left(bench.folder, "first", "second")
    terminal = bench.terminal(f'sh("{script}", emulate_tty={tty}), sh("exec sleep 1000")')
    terminal.wait_for("process has finished cleanly")
    for text in ("first", "second"):
        (bench.folder / text).touch()
        terminal.wait_for(text)
    wait_until((bench.folder / "done").exists, "it has not ended by SIGPIPE")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    assert _log(bench, "sh-1.log") == "[sh-1] first\n[sh-1] second\n"


def test_what_a_life_has_left_writes_beside_the_next_one(control_bench: ControlBench):
    folder = control_bench.folder
    (folder / "node.sh").write_text(
        f"cd {folder}; if [ ! -e away ]; then\n"
        f"setsid sh -c 'touch away; {_left(folder, 'shown', 'muted', 'last')} wait' &\n"
        "until [ -e away ]; do sleep 0.01; done; exit 1; fi\n"
        "echo successor; exec sleep 1000"
    )
    actions = f'sh("exec sh {folder}/node.sh", name="node", respawn=True)'
    with control_bench.launch(actions) as run:
        run.wait_for("[node-1] successor\n")
        (folder / "shown").touch()
        run.wait_for("[node-1] shown\n")
        run.ask("mute", "node")
        (folder / "muted").touch()
        run.wait_for_log("node", "muted")
        run.ask("unmute", "node")
        (folder / "last").touch()
        run.wait_for("[node-1] last\n")
        wait_until((folder / "done").exists, "it has not ended by SIGPIPE")
        assert "[node-1] muted\n" not in run.screen


def test_the_last_words_of_what_is_left_at_the_end_are_read(bench: Bench):
    (bench.folder / "daemon.sh").write_text(
        "trap 'echo last words; exit' TERM; touch ready; while :; do sleep 0.02; done"
    )
    waits = "until [ -e ready ]; do sleep 0.02; done"
    done = bench.run(f'sh("sh ./daemon.sh & {waits}", cwd="{bench.folder}")')
    before, _, after = done.stdout.decode().partition("stopping leftover processes")
    assert "last words" not in before
    assert "[sh-1] last words\n" in after
    assert done.returncode == 0


def test_handlers_of_the_launch_file_get_it(bench: Bench):
    handler = f"{ON_IO}(on_stdout=lambda io: [LogInfo(msg=['handled ', io.text.decode()])])"
    actions = f'sh("{_left(bench.folder, "late")}"), sh("exec sleep 1000")'
    terminal = bench.terminal(f"RegisterEventHandler({handler}), {actions}")
    terminal.wait_for("process has finished cleanly")
    (bench.folder / "late").touch()
    terminal.wait_for("handled late")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0


def test_a_host_reads_it_and_its_last_words(tmp_path: Path):
    daemon = "trap 'echo last words; exit' INT; echo ready; while :; do sleep 0.02; done"
    code = f"import subprocess; subprocess.Popen(['sh', '-c', {daemon!r}], start_new_session=True)"
    with Recorder() as recorder:
        recorder.ready().start(1, python(code, merge=True))
        recorder.until(lambda: recorder.exits() == [0], "it has exited")
        recorder.until(lambda: recorder.text() == b"ready\n", "its child is read")
        recorder.finish()
        assert recorder.text() == b"ready\nlast words\n"


# ---- the reader alone


class Listener:
    """The supervisor of one process."""

    def watches(self, process: Process) -> bool:
        return False


def test_a_line_of_an_earlier_life_does_not_make_the_next_one_ready(tmp_path: Path):
    with Reactor() as reactor, open(tmp_path / "screen", "wb") as screen:
        reader, process = _reader(reactor, screen.fileno())
        seen: list[bytes] = []
        process.on_lines = seen.append
        writers = [_begin_life(process, reader) for _ in range(2)]
        for text, writer in zip((b"old\n", b"new\n"), writers, strict=True):
            os.write(writer, text)
            os.close(writer)
        reactor.call_later(0, lambda: reactor.call_later(0, reactor.stop))
        reactor.run()
        reader.detach(process)
    assert seen == [b"new\n"]
    assert (tmp_path / "screen").read_bytes() == b"[a] old\n[a] new\n"


def test_lines_of_an_earlier_life_of_composed_nodes_keep_their_names(tmp_path: Path):
    tokens = b"0" * 16, b"1" * 16
    with contextlib.ExitStack() as stack, Reactor() as reactor:
        screen = stack.enter_context(open(tmp_path / "screen", "wb"))
        reader, process = _reader(reactor, screen.fileno())
        process.group = GroupOutput(("a", b"[a] "), [("n", b"[n] ")], lambda index, code: None)
        writers = []
        for token in tokens:
            ours, theirs = map(stack.enter_context, socket.socketpair(type=socket.SOCK_SEQPACKET))
            ours.setblocking(False)
            writers.append(_begin_life(process, reader, ours.fileno()))
            theirs.send(b"token %b" % token)
        for token, writer in zip(tokens, writers, strict=True):
            os.write(writer, b"\x1e%b0\x1f%b\n" % (token, token))
            os.close(writer)
        reactor.call_later(0, lambda: reactor.call_later(0, reactor.stop))
        reactor.run()
        reader.drain(process)
        reader.detach(process)
    lines = (tmp_path / "screen").read_bytes().splitlines()
    assert sorted(lines) == [b"[n] %b" % token for token in tokens]


def _reader(reactor: Reactor, screen: int) -> tuple[OutputReader, Process]:
    reader = OutputReader(
        reactor,
        StdoutWriter(reactor, screen, colour=False),
        RunDirectory(None, lambda text: None),
        (),
        Listener(),
    )
    policy = OutputPolicy.named("screen")
    spec = ProcessSpec(name="a", label="a", argv=("a",), env={}, output=policy)
    return reader, Process(0, spec, number=0, prefix=b"[a] ")


def _begin_life(process: Process, reader: OutputReader, stdin: int = -1) -> int:
    """The end that the new child writes to; what an earlier one had is kept."""
    if process.child is not None:
        reader.drain(process)
        reader.keep(process)
    read_end, write_end = os.pipe()
    os.set_blocking(read_end, False)
    process.child = Child(-1, {read_end: BOTH}, -1, stdin, -1)
    reader.attach(process)
    return write_end


FILES = 96  # for the launcher


@pytest.mark.thorough
def test_what_is_kept_leaves_descriptors_for_the_run(control_bench: ControlBench):
    """Each life leaves a daemon that holds its pipe: the oldest are closed, with a warning."""
    folder = control_bench.folder
    (folder / "lives").touch()
    (folder / "node.sh").write_text(
        f"cd {folder}; rm -f up; setsid sh -c 'touch up; exec sleep 1000' &\n"
        "until [ -e up ]; do sleep 0.01; done; echo x >>lives; exit 1"
    )
    actions = f'sh("exec sh {folder}/node.sh", name="node", respawn=True)'
    with control_bench.launch(actions, files=FILES) as run:
        wait_until(lambda: (folder / "lives").read_text().count("x") > FILES, "many lives")
        assert "what node-1 has left running is not read any more" in run.screen
        assert "Too many open files" not in run.screen
        assert run.open_files() < FILES - 8
        run.ask("stop", "node")
        # Each of the closed ones is named.
        assert len(re.findall("is not read any more", run.screen)) >= FILES // 2 - 1
