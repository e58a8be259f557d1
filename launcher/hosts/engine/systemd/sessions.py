"""The two sessions with a host: a shell for scripts, and one that follows the journal.

They share one connection. Both are renewed as often as they break; the journal goes on behind the
last entry that came, so that nothing is lost.
"""

from __future__ import annotations

import contextlib
import os
from collections import deque
from typing import Protocol

from launcher.base.errors import LauncherError
from launcher.hosts.engine.link import LinkContext, LinkState
from launcher.hosts.engine.systemd import journal
from launcher.hosts.engine.systemd.channel_process import ChannelProcess
from launcher.hosts.engine.systemd.host_facts import HostFacts, hello, read_facts
from launcher.hosts.engine.systemd.journal import Entry
from launcher.hosts.engine.systemd.shell import START, Answers, ScriptRequest, ScriptResult
from launcher.hosts.engine.timers import Timers
from launcher.hosts.failures import failure, no_ssh
from launcher.hosts.ssh import SshConnection, new_control_path, quoted, ssh_environment


class SessionsListener(Protocol):
    """Called back by the event loop, never from within a call of `Sessions`."""

    # The facts of the host have come for the first time; the reason to refuse it, or "". None:
    # the sessions were closed.
    def met(self, facts: HostFacts) -> str | None: ...

    # As `met`, when it is reached again; whether it is the same host and was not restarted.
    def met_again(self, facts: HostFacts) -> bool: ...

    # READY after UNREACHABLE comes when the journal has been caught up with.
    def changed(self, state: LinkState, reason: str) -> None: ...
    def entry(self, entry: Entry) -> None: ...

    # The journal has removed entries before they were read.
    def missed(self) -> None: ...

    # A script for the journal: the record of this mark.
    def mark(self, token: str) -> str: ...


SILENT_S = 3.0  # without a beat of the shell, which has one each second, and without lines
MUTE_S = 12.0  # without a beat, while lines come: they may fill a slow link, or the shell is dead
CONNECT_S = 15.0  # for the first answer of a host
AGAIN_S = (0.1, 0.5, 1.0, 2.0, 5.0)  # between attempts to reconnect
ATTEMPT_S = 6.0  # for an attempt to reconnect
JOURNAL_AGAIN_S = 0.2
CATCH_UP_S = 10.0  # for the mark to come through the journal
# Later beats would change the offset while processes live, whose times would not fit together.
_BEATS = 5


class Sessions:
    """`run` is the short id of the run, which is part of what the journal is asked for."""

    def __init__(self, context: LinkContext, run: str, listener: SessionsListener) -> None:
        self._context = context
        self._reactor = context.reactor
        self._run = run
        self._listener = listener
        self.state = LinkState.CONNECTING
        self.clock = HostClock()
        self.reader = journal.JournalReader(run)
        self._connection: SshConnection
        self._control_path = ""
        self._shell: ChannelProcess | None = None
        self._journal: ChannelProcess | None = None
        self._answers = Answers(self._beat)
        self._heard_s = self._beat_s = self._reactor.now()
        self._queue: deque[ScriptRequest] = deque()
        self._timers = Timers(self._reactor)
        self._attempts = 0
        self._mark = ""  # the last that was asked for
        self._has_met = False
        self._is_paused = False
        self._is_following = False  # of a run that is attached to, not from the beginning
        self._first: str | None = None

    @property
    def silent_s(self) -> float:
        return self._reactor.now() - self._heard_s

    # ---- connecting

    def open(self) -> None:
        """Connect; the listener is called with the outcome."""
        self._timers.after("connect", 0.0, self._connect_first)

    def _connect_first(self) -> None:
        try:
            self._control_path = new_control_path(self._context.environment)
            self._connection = SshConnection(self._context.host, self._control_path)
        except LauncherError as error:
            self._refuse(error.message)
            return
        self._connect()

    def _connect(self) -> None:
        self._answers = Answers(self._beat)
        self._beat_s = self._reactor.now()
        try:
            self._shell = ChannelProcess(
                self._reactor,
                self._connection.leader("exec sh"),
                ssh_environment(self._context.environment),
                on_data=self._shell_data,
                on_end=self._shell_ended,
            )
        except FileNotFoundError:
            error = no_ssh(self._context.host)
            self._change(LinkState.UNREACHABLE, f"{error.message}; {error.hint}")
            return
        asked = ScriptRequest(hello(self._context.host), self._said_hello, lasts=False)
        self._shell.write(START.encode() + self._answers.framed(asked))
        limit_s = ATTEMPT_S if self._has_met else CONNECT_S
        self._timers.after("limit", limit_s, lambda: self._lose(f"no answer within {limit_s:g} s"))

    def _said_hello(self, answer: ScriptResult) -> None:
        self._timers.cancel("limit")
        try:
            facts = read_facts(answer.text)
        except (KeyError, ValueError):
            self._refuse("its shell does not answer as a POSIX shell does")
            return
        if not self._has_met:
            refusal = self._listener.met(facts)
            if refusal is None:
                return  # this has been closed
            if refusal:
                self._refuse(refusal)
                return
            self._has_met = True
            if self._context.attached is None:
                self.follow(behind=facts.cursor)
            self._timers.after("watch", 1.0, self._check_silence)
            self._change(LinkState.READY, "")
        else:
            is_same = self._listener.met_again(facts)
            if self._shell is None:
                return
            if is_same and not self._is_following:
                self._caught_up()
            elif is_same:
                self._check_cursor()
                self._follow()
                self._catch_up()
            else:  # its lines have ended with it
                self.clock = HostClock()
                self._follow()
                self._caught_up()
            self._timers.after("watch", 1.0, self._check_silence)

    def give_up(self, reason: str) -> None:
        """Leave for ever; the listener is called after that."""
        self._refuse(reason)

    def _refuse(self, reason: str) -> None:
        self._drop()
        self._change(LinkState.GONE, reason)

    def _catch_up(self) -> None:
        self._mark = journal.new_mark()
        self._send(ScriptRequest(self._listener.mark(self._mark), lasts=False))
        self._timers.after("mark", CATCH_UP_S, self._caught_up)

    def _caught_up(self) -> None:
        self._timers.cancel("mark")
        self._attempts = 0
        self._change(LinkState.READY, "")
        while self._queue and self._shell is not None:
            self._send(self._queue.popleft())

    # ---- the shell

    def request(self, request: ScriptRequest) -> None:
        """Run a script there; after the link is back if it is broken."""
        if self.state is LinkState.READY and not self._queue:
            self._send(request)
        else:
            self._queue.append(request)

    def send_beat(self, script: str) -> None:
        """Run it there as soon as the shell answers, also while the journal is caught up with."""
        if self._shell is not None and "limit" not in self._timers:
            self._send(ScriptRequest(script, lasts=False))

    @property
    def has_requests(self) -> bool:
        """Whether one that lasts was not answered yet: the host may not know of it."""
        return any(one.lasts for one in (*self._queue, *self._answers.unanswered))

    def forget_requests(self) -> None:
        self._queue.clear()

    def _send(self, request: ScriptRequest) -> None:
        assert self._shell is not None
        self._shell.write(self._answers.framed(request))

    def _shell_data(self, data: bytes) -> None:
        self._heard_s = self._beat_s = self._reactor.now()
        self._answers.feed(data)

    def _beat(self, uptime_s: float) -> None:
        self.clock.heard(uptime_s, self._reactor.now())

    def _shell_ended(self, returncode: int, errors: str) -> None:
        error = failure(self._context.host, errors, returncode)
        if not self._has_met:
            self._drop()
            state = LinkState.UNREACHABLE if error.problem.may_pass else LinkState.GONE
            self._change(state, f"{_own_words(error.message)}; {error.hint}".removesuffix("; None"))
        else:
            self._lose(_own_words(error.message) if errors.strip() else "the session has ended")

    def _check_silence(self) -> None:
        mute_s = self._reactor.now() - self._beat_s
        if self.silent_s > SILENT_S or mute_s > MUTE_S:
            self._lose(f"silent for {max(self.silent_s, mute_s):.0f} s")
        else:
            self._timers.after("watch", 1.0, self._check_silence)

    def _lose(self, reason: str) -> None:
        waiting = self._answers.unanswered
        self._drop()
        if not self._has_met:
            self._change(LinkState.UNREACHABLE, reason)
            return
        self._queue.extendleft(reversed([one for one in waiting if one.lasts]))
        for one in waiting:
            if not one.lasts and one.on_loss is not None:
                self._reactor.call_later(0, one.on_loss)
        self._change(LinkState.UNREACHABLE, reason)
        delay_s = AGAIN_S[min(self._attempts, len(AGAIN_S) - 1)]
        self._attempts += 1
        self._timers.after("connect", delay_s, self._connect)

    def _drop(self) -> None:
        for channel in (self._shell, self._journal):
            if channel is not None:
                channel.close()
        self._shell = self._journal = None
        if self._control_path:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(self._control_path)
        for name in ("limit", "mark", "watch", "follow"):
            self._timers.cancel(name)

    def _change(self, state: LinkState, reason: str) -> None:
        if state is not self.state:
            self.state = state
            self._listener.changed(state, reason)

    # ---- the journal

    def follow(self, *, behind: str | None = None, first: str | None = None) -> None:
        """Follow the journal from behind an entry, or from one on; once, while READY."""
        self._is_following = True
        self.reader.cursor, self._first = behind, first
        self._follow()

    def _follow(self) -> None:
        self.reader.restart()
        words = quoted(journal.words(self._run, self.reader.cursor, first=self._first))
        # It ends with its input, so that none stays behind a connection that broke.
        leash = '{ cat <&3 >/dev/null 2>&1; kill "$$"; } >/dev/null 2>&1 &'
        self._journal = ChannelProcess(
            self._reactor,
            self._connection.session(f"exec 3<&0; {leash} exec {words} 3<&-"),
            ssh_environment(self._context.environment),
            on_data=self._journal_data,
            on_end=self._journal_ended,
        )
        self._journal.pause(self._is_paused)

    def _check_cursor(self) -> None:
        """Where the last entry has been removed, others behind it may have been, too."""
        cursor = self.reader.cursor
        if cursor is None:
            return

        def answered(answer: ScriptResult) -> None:
            if journal.is_gone(cursor, answer.text):
                self._listener.missed()

        self._send(ScriptRequest(journal.entry_at(cursor), answered, lasts=False))

    def _journal_data(self, data: bytes) -> None:
        self._heard_s = self._reactor.now()
        for entry in self.reader.feed(data):
            is_mark = isinstance(entry, journal.Note) and entry.words == ("mark", self._mark)
            if is_mark and "mark" in self._timers:
                self._caught_up()
            self._listener.entry(entry)

    def _journal_ended(self, returncode: int, errors: str) -> None:
        self._journal = None
        if self._shell is not None:
            self._check_cursor()
            self._timers.after("follow", JOURNAL_AGAIN_S, self._follow)

    def pause(self, paused: bool) -> None:
        """Do not read the journal, or go on."""
        self._is_paused = paused
        if self._journal is not None:
            self._journal.pause(paused)

    # ---- the end

    def close(self) -> None:
        """End both sessions; idempotent."""
        self._drop()
        self._timers.close()


def _own_words(message: str) -> str:
    """A message without `host 'bot1': `, which the run says itself."""
    return message.partition("': ")[2] or message


class HostClock:
    """The monotonic clock of a host on ours.

    The offset is from the beats that came fastest, of the first few.
    """

    def __init__(self) -> None:
        self._offset_s: float | None = None
        self._beats = 0

    def heard(self, host_s: float, now: float) -> None:
        """The time of the host has just come."""
        if self._offset_s is None:
            self._offset_s = now - host_s
        elif self._beats < _BEATS:
            self._offset_s = min(self._offset_s, now - host_s)
        self._beats += 1

    def there(self, now: float) -> float:
        """Our time on the clock of the host."""
        return now if self._offset_s is None else now - self._offset_s

    def here(self, host_s: float, now: float) -> float:
        """A time of the host on our clock, not later than now."""
        return now if self._offset_s is None else min(now, host_s + self._offset_s)
