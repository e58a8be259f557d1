"""Records events, lines and resource usage that a run sends, in threads that end with it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from launcher.base.model.event_entries import entry_of
from launcher.control.client import Connection
from launcher.posix.socket_directory import ControlError
from launcher.smoke.observe import log_files
from launcher.smoke.observe.fact_recorder import FactRecorder
from launcher.smoke.observe.facts import LogLine, UsageSample

SAMPLE_S = 1.0
ANSWER_S = 5.0  # a run that does not answer `ps` within this time is no longer sampled
WHOLE_LOG = 1_000_000  # lines: all that the run keeps

Rows = Sequence[Mapping[str, Any]]


class RunFollower:
    """`connect` makes a connection to the run, ControlError; `on_rows` gets what `ps` answers."""

    def __init__(
        self,
        connect: Callable[[], Connection],
        recorder: FactRecorder,
        on_rows: Callable[[Rows], object],
        *,
        lines: int = WHOLE_LOG,
        max_rate: int | None = None,
    ) -> None:
        self._connect = connect
        self._recorder = recorder
        self._on_rows = on_rows
        self.dropped_lines = 0
        self._is_over = threading.Event()
        of_lines = {"lines": lines} | ({} if max_rate is None else {"max_rate": max_rate})
        self.threads = [
            _started(self._follow, "events", self._event, {"history": True}),
            _started(self._follow, "logs", self._line, of_lines),
            _started(self._sample),
        ]

    def end(self) -> None:
        """Take no more samples; the rest ends with the run."""
        self._is_over.set()

    def _follow(
        self, verb: str, take: Callable[[Mapping[str, Any]], None], options: Mapping[str, Any]
    ) -> None:
        try:
            with self._connect() as connection:
                for item in connection.follow(verb, **options):
                    take(item)
        except ControlError:
            pass  # the run is over; its files have the rest

    def _event(self, item: Mapping[str, Any]) -> None:
        entry = entry_of(item)
        if entry is not None:  # else some were not read in time
            self._recorder.add(log_files.event_of(entry, self._recorder))

    def _line(self, item: Mapping[str, Any]) -> None:
        if "dropped" in item:
            self.dropped_lines += int(item["dropped"])
            return
        self._recorder.add(
            LogLine(
                at_s=self._recorder.of_wall(item["wall_s"]),
                process=item["process"],
                text=item["text"],
                stream=item["stream"],
            )
        )

    def _sample(self) -> None:
        try:
            with self._connect() as connection:
                while not self._is_over.is_set():
                    self._take_sample(connection)
                    self._is_over.wait(SAMPLE_S)
        except ControlError:
            pass  # the run is over

    def _take_sample(self, connection: Connection) -> None:
        rows = connection.ask("ps", timeout_s=ANSWER_S).result["processes"]
        at_s = self._recorder.now_s
        self._on_rows(rows)
        samples = [
            UsageSample(at_s, row["name"], row["cpu_percent"], row["uss_bytes"])
            for row in rows
            if row["pid"] is not None
        ]
        nodes = {row["name"]: tuple(row["node_names"]) for row in rows}
        self._recorder.add_samples(samples, nodes)


def _started(work: Callable[..., None], *args: object) -> threading.Thread:
    name = " ".join([work.__name__, *(one for one in args if isinstance(one, str))])
    thread = threading.Thread(target=work, args=args, daemon=True, name=name)
    thread.start()
    return thread
