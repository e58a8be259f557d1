"""What entries of the journal mean: output, and events of the processes that wrote it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping

from launcher.base.text import count
from launcher.hosts.engine.link import LinkListener
from launcher.hosts.engine.systemd import journal
from launcher.hosts.engine.systemd.exits import TIMEOUT, outcome_of_record
from launcher.hosts.engine.systemd.journal import Entry, JournalLine, Note, UnitMessage
from launcher.hosts.engine.systemd.unit_process import UnitProcess
from launcher.hosts.engine.timers import Timers
from launcher.output.lines import for_terminal, without_colour
from launcher.output.tracebacks import has_begin
from launcher.posix.reactor import Reactor

SILENT_S = 30.0  # without any entry: a mark does not come any more
LIMBO_S = 2.0  # for the record that says whose output it is
# Several looks, between which entries are read: the loop may have been delayed. The journal
# passes on lines up to 0.25 s late.
REST_LOOKS, REST_PERIOD_S = 3, 0.2
# The default limit of the journal, for all units of a user together; more where the disk is large.
BURST, INTERVAL_S = 10_000, 30.0
MAY_LOSE = (
    "the journal may drop lines of users with more than 10000 in 30 s; to keep all, set"
    " RateLimitBurst=0 in its /etc/systemd/journald.conf"
)
GENERATIONS = 2  # the output of a process may come when it has been started again


class JournalEvents:
    """Passes entries on to `units` and to the listener.

    `by_unit` are process ids by the names of units, `uid` is the user on the host. Records and
    messages from before `begin_s`, on the clock of the host, only say whose output it is.
    """

    def __init__(
        self,
        host: str,
        listener: LinkListener,
        reactor: Reactor,
        units: Mapping[int, UnitProcess],
    ) -> None:
        self._host = host
        self._listener = listener
        self._reactor = reactor
        self._units = units
        self.uid = 0
        self.begin_s = float("-inf")
        self._is_past = False
        self.by_unit: dict[str, int] = {}
        self._marks: dict[str, Callable[[], None]] = {}
        self._owners = Owners()
        self._limbo: list[tuple[JournalLine, float]] = []
        self._timers = Timers(reactor)
        self._heard_s = 0.0
        self._flood = Flood()
        self._unfinished: dict[tuple[int, str], int] = {}  # looks since it wrote
        self.is_paused = False  # nothing is read

    def begin(self, begin_s: float) -> None:
        """What comes from before this time is past."""
        self.begin_s, self._is_past = begin_s, True

    def end_past(self) -> None:
        """What comes from now on is new; idempotent."""
        if self._is_past:
            self.begin_s, self._is_past = float("-inf"), False
            self._listener.past_complete(self._host)

    def when_marked(self, token: str, callback: Callable[[], None]) -> None:
        """Call back when the record of this mark has come, or nothing comes any more."""
        self._marks[token] = callback
        self._heard_s = self._reactor.now()
        self._await_entries(SILENT_S)

    def _await_entries(self, delay_s: float) -> None:
        self._timers.after("silence", delay_s, self._check_silence)

    def _check_silence(self) -> None:
        left_s = self._heard_s + SILENT_S - self._reactor.now()
        if left_s > 0:
            self._await_entries(left_s)
            return
        for token in list(self._marks):
            self._came(token)

    def _came(self, token: str) -> None:
        if token in self._marks:
            self._reactor.call_later(0, self._marks.pop(token))
        if not self._marks:
            self._timers.cancel("silence")

    def feed(self, entry: Entry, at_s: float) -> None:
        self._heard_s = self._reactor.now()
        if self._is_past and entry.monotonic_s >= self.begin_s:
            self.end_past()
        if isinstance(entry, JournalLine):  # processes may change their user, so these are of any
            self._line(entry, at_s)
        elif entry.uid != self.uid:
            return
        elif isinstance(entry, Note) and entry.words[:1] == ("mark",):
            for token in entry.words[1:2]:
                self._came(token)
        elif isinstance(entry, Note):
            self._note(entry, at_s)
        elif entry.monotonic_s >= self.begin_s:
            self._message(entry, at_s)

    def close(self) -> None:
        self._timers.close()

    # ---- output

    def _owner(self, line: JournalLine) -> int | None:
        """The process; None if it is unknown, at least so far."""
        found = self.by_unit.get(line.unit)
        if found is None:
            by_stream = self._owners.get(line.stream_id)
            found = self._owners.get(line.pid) if by_stream is None else by_stream
        if found is not None and line.stream_id:
            self._owners.add(line.stream_id, found)
        return found

    def announces(self, line: JournalLine) -> bool:
        """Whether it only says whose stream it is; that is kept.

        A process without such streams (of root, with both in one) may write the same text, and any
        may write that of another.
        """
        found = journal.announced(line)
        one = self._units.get(found)
        if one is None or self.by_unit.get(line.unit, found) != found:
            return False
        if one.order.merge and not self.uid:
            return False
        self._owners.add(line.stream_id, found)
        return True

    def _line(self, line: JournalLine, at_s: float) -> None:
        if self.announces(line):
            return
        process_id = self._owner(line)
        if process_id is None:
            if line.uid == self.uid:  # else of this run on another host, the same machine
                self._limbo.append((line, at_s))
                self._timers.after("limbo", LIMBO_S, self.give_up_limbo)
            return
        one = self._units[process_id]
        one.wrote(len(line.data))
        stream = "both" if one.order.merge else line.stream
        # Exits of the past, which would end the line, are not reported.
        ends = line.is_last and line.monotonic_s < self.begin_s
        self._listener.output(process_id, stream, line.data + b"\n" * ends, at_s)
        if not self._is_past:
            self._expect_rest((process_id, stream), line.data)
        if self.uid and self._flood.is_above(at_s):
            self._listener.warn(self._host, MAY_LOSE)

    def _expect_rest(self, stream: tuple[int, str], data: bytes) -> None:
        """Of a long line, which comes in pieces, or of a traceback."""
        if stream in self._unfinished or not data.endswith(b"\n") or has_begin(data):
            self._unfinished[stream] = 0
            if "rest" not in self._timers:
                self._timers.after("rest", REST_PERIOD_S, self._look_for_silence)

    def _look_for_silence(self) -> None:
        for stream, looks in list(self._unfinished.items()):
            self._unfinished[stream] = 0 if self.is_paused else looks + 1
            if self._unfinished[stream] == REST_LOOKS:
                del self._unfinished[stream]
                self._listener.output(*stream, b"", self._reactor.now())
        if self._unfinished:
            self._timers.after("rest", REST_PERIOD_S, self._look_for_silence)

    def give_up_limbo(self) -> None:
        """Report output of which it is not known whose it is."""
        if not self._limbo:
            return
        line, _ = self._limbo[0]
        text = without_colour(for_terminal(line.data)).decode(errors="replace").rstrip("\n")
        lines = count(len(self._limbo), "line")
        self._listener.warn(self._host, f"{lines} of an unknown process; the first: {text}")
        self._limbo.clear()

    def started(self, process_id: int, pid: int) -> None:
        """Output of this pid, and what came of it before this was known, is of the process."""
        self._owners.started(process_id, pid)
        limbo, self._limbo = self._limbo, []
        for line, at_s in limbo:
            self._line(line, at_s)

    # ---- events

    def _note(self, note: Note, at_s: float) -> None:
        is_past = note.monotonic_s < self.begin_s
        match note.words:
            case ("start", number, invocation, pid) if one := self._numbered(number):
                if not is_past:
                    one.noted_start(invocation, int(pid), at_s)
                self.started(one.process_id, int(pid))
            case _ if is_past:
                return
            case ("exit", number, invocation, result, code, status):
                exited = self._numbered(number)
                if exited is not None and result != "exec-condition" and code != "-":
                    outcome = outcome_of_record(result, code, status)
                    timed_out = result == TIMEOUT
                    exited.noted_exit(invocation, outcome, at_s, timed_out=timed_out)
            case ("expired", waited):
                self._expired(waited, at_s)
            case ("ended", *operator):
                self._listener.run_ended(self._host, " ".join(operator))

    def _numbered(self, number: str) -> UnitProcess | None:
        return self._units.get(int(number)) if number.isdecimal() else None

    def _expired(self, waited: str, at_s: float) -> None:
        text = f"stopped its processes after {waited} s without the launcher"
        self._listener.warn(self._host, text)
        for one in self._units.values():
            one.noted_stop(at_s, by_user=False)

    def _message(self, message: UnitMessage, at_s: float) -> None:
        process_id = self.by_unit.get(message.unit)
        if process_id is None:
            return
        one = self._units[process_id]
        if message.message_id == journal.STOPPING:
            one.noted_stop(at_s, by_user=True)
        elif message.message_id == journal.RESTART_SCHEDULED:
            one.noted_restart(at_s)
        elif message.result == "start-limit-hit":
            one.noted_refusal(at_s, "systemd has given it up (start-limit-hit)")


class Flood:
    """Counts lines, and reports once if they are so many that the journal may drop some."""

    def __init__(self) -> None:
        self._since_s, self._lines, self._is_reported = 0.0, 0, False

    def is_above(self, at_s: float) -> bool:
        if at_s - self._since_s > INTERVAL_S:
            self._since_s, self._lines = at_s, 0
        self._lines += 1
        if self._lines < BURST or self._is_reported:
            return False
        self._is_reported = True
        return True


class Owners:
    """Whose output it is that comes without the name of a unit.

    Processes by the pids and the streams of their last starts; older ones are forgotten.
    """

    def __init__(self) -> None:
        self._owners: dict[int | str, int] = {}
        self._starts: dict[int, deque[set[int | str]]] = {}

    def __len__(self) -> int:
        return len(self._owners)

    def get(self, key: int | str) -> int | None:
        return self._owners.get(key)

    def started(self, process_id: int, pid: int) -> None:
        if self._owners.get(pid) == process_id:
            return  # it is reported twice
        starts = self._starts.setdefault(process_id, deque())
        starts.append(set())
        if len(starts) > GENERATIONS:
            for key in starts.popleft().difference(*starts):
                if self._owners.get(key) == process_id:
                    del self._owners[key]
        self.add(pid, process_id)

    def add(self, key: int | str, process_id: int) -> None:
        """A pid or a stream is of this process."""
        self._owners[key] = process_id
        starts = self._starts.setdefault(process_id, deque([set()]))
        starts[-1].add(key)
