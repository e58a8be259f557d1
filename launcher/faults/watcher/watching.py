"""Has a run observed and judged, several times a second, until its end."""

from __future__ import annotations

import os
import queue
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from launcher.base.model.run_events import Stopping
from launcher.control.client import Connection
from launcher.faults.checks.check import Check
from launcher.faults.checks.live_checks import checks_of, implied_checks, watched
from launcher.faults.history.versions import FilesVersion, of_launch
from launcher.faults.history.writing import FaultHistory
from launcher.faults.model.fault import Fault
from launcher.faults.watcher.fault_table import FaultTable
from launcher.faults.watcher.handover import Handover
from launcher.faults.watcher.incident_files import IncidentFiles, first_number
from launcher.faults.watcher.machine_facts import MachineReader
from launcher.faults.watcher.observations import Observations
from launcher.faults.watcher.parameter_watch import ParameterWatch
from launcher.faults.watcher.story import Story, is_here
from launcher.faults.watcher.topic_watch import TopicWatch
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.smoke.expect.evaluator import EVALUATOR
from launcher.smoke.expect.script import Script
from launcher.smoke.observe.probe_client import ProbeClient, ProbeError
from launcher.smoke.observe.run_follower import RunFollower
from launcher.smoke.preflight import loader

TICK_S = 0.1  # processes that are suspended again and again are looked at so often
LOOK_S = 0.2  # between two looks of the checks
MACHINE_S = 0.5
BEAT_S = 2.0  # so often, the launcher gets a line
LINES = 100  # of before the watch began
MISSED_LINES = 1000  # of which those since an earlier watcher has reported last are judged
MAX_RATE = 500  # lines of one process in a second: more are counted only
MANY_PIDS = 20  # more are looked at less often
PROBE_LOG = "probe.log"
MAX_STARTS = 3  # of the probe

Say = Callable[..., object]


@dataclass(frozen=True, slots=True, kw_only=True)
class WatchSettings:
    """What the launcher passes on.

    `arguments` are those of the launch file, and `files` what it has included and read; `expect` is
    the file of expectations, if there is one.
    """

    socket: str
    run_folder: str | None
    launch_file: str
    arguments: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    expect: str | None = None


class FaultWatcher:
    """`say` writes a line for the launcher; `requests` are its lines."""

    def __init__(self, settings: WatchSettings, requests: queue.SimpleQueue[Any], say: Say) -> None:
        self._settings = settings
        self._requests = requests
        self._say = say
        self._observations = Observations()
        self._rows: queue.SimpleQueue[Sequence[Mapping[str, Any]]] = queue.SimpleQueue()
        self._graphs: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._story = Story()
        self._handover = Handover()
        self._machine = MachineReader(settings.run_folder)
        self._table = FaultTable(self._report, first_number(settings.run_folder))
        self._history: FaultHistory | None = None
        self._versions: dict[str, str | None] = {}
        self._probe: ProbeClient | None = None
        self._probe_starts = 0
        self._topics: TopicWatch | None = None
        self._parameters: ParameterWatch | None = None
        self._implied: list[Check] = []
        self._checks: list[Check] = []  # of the expectations
        self._is_over = False
        self._beat_s = self._look_s = self._machine_s = self._pids_s = 0.0

    # ---- beginning

    def run(self) -> None:
        """Watch until the run is over; LauncherError for mistakes in the expectations."""
        begin = self._requests.get()
        if begin["do"] != "begin":
            return  # the run has ended
        written_s = begin["written_s"]
        path = self._settings.expect
        script = Script() if path is None else loader.load(path).completed()
        with Connection(self._settings.socket) as connection:
            hello = connection.hello
            earlier = connection.ask("faults").result
        self._observations.begin()
        if written_s is not None:
            self._handover.resume(self._observations.of_wall(written_s))
        self._table.resume(earlier["faults"], self._observations.of_wall)
        self._table.mutes.update((one.pop("fault"), one) for one in earlier["mutes"])
        follower = RunFollower(
            lambda: Connection(self._settings.socket),
            self._observations,
            self._rows.put,
            lines=LINES if written_s is None else MISSED_LINES,
            max_rate=MAX_RATE,
        )
        self._environment = _environment(hello["run"])
        self._begin_history(hello)
        self._script, left = watched(script)
        self._say(left=[{"expectation": one.expectation, "why": one.why} for one in left])
        self._implied = implied_checks(script)
        self._start_probe()
        if not self._checks:
            self._checks = checks_of(self._script, self._settings.arguments)
        checks = (*self._implied, *self._checks)
        self._say(
            names=[name for check in checks for name in check.names],
            counts=[len(self._checks), len(self._implied)],
            mutes=self._table.mutes,
        )
        try:
            self._loop()
        finally:
            follower.end()
            self._end()

    def _begin_history(self, hello: Mapping[str, Any]) -> None:
        """Of this run, beside earlier ones; faults that were muted in these stay so."""
        folder, run, target = self._settings.run_folder, hello["run"], self._settings.launch_file
        self._versions = {"launch_file": target, "hash": None, "git": None}
        head = {**_head(hello), "versions": self._versions}
        self._files = IncidentFiles(folder, head, self._observations.wall_of, self._note)
        if folder is None:
            return
        self._history = history = FaultHistory(os.path.dirname(folder), self._note)
        self._table.mutes.update(history.mutes_of(target))
        history.begin_run(
            run=run["id"],
            target=target,
            started_s=run["started_wall_s"],
            version_of=self._version,
            launcher=hello["launcher"],
            log_dir=folder,
        )

    def _version(self) -> FilesVersion:
        """In the thread of the history: git may take seconds."""
        found = of_launch(self._settings.launch_file, self._settings.files)
        self._versions.update(hash=found.files_hash, git=found.git)
        return found

    def _start_probe(self) -> None:
        """Observe ROS; without a probe, processes and lines are still watched."""
        self._probe_starts += 1
        folder = self._settings.run_folder
        log = Path(os.devnull) if folder is None else Path(folder, PROBE_LOG)
        try:
            probe = ProbeClient(self._environment, self._observations, log, self._graphs.put)
        except OSError as error:
            self._note(f"ROS is not observed: {error.strerror or error}")
            return
        try:
            probe.wait_until_ready()
        except ProbeError as error:
            probe.close()
            self._note(f"ROS is not observed: {error.message}: {error.hint or 'no output'}")
            return
        self._probe = probe
        self._story.observer = probe.pid
        self._handover.subscribe(self._observations.now_s)
        self._topics = TopicWatch(probe, self._observations, self._script.expectations)
        self._script = self._script.with_expectations(self._topics.expectations)
        if not self._checks:  # else a new probe has the same subscriptions
            self._checks = checks_of(self._script, self._settings.arguments)
        self._parameters = ParameterWatch(probe, self._observations, self._script.expectations)

    # ---- the loop

    def _loop(self) -> None:
        next_s = time.monotonic()
        while not self._is_over:
            self._take_requests()
            if not self._story.is_stopping:
                self._tick()
            next_s = max(next_s + TICK_S, time.monotonic() + TICK_S / 10)
            time.sleep(max(0.0, next_s - time.monotonic()))

    def _tick(self) -> None:
        story, now_s = self._story, self._observations.now_s
        if now_s >= self._beat_s:
            self._beat_s = now_s + BEAT_S
            self._say(alive=True)
        self._take_states()
        pids = [r["pid"] for r in story.rows if r["pid"] is not None and is_here(r)]
        if now_s >= self._pids_s:
            self._pids_s = now_s + TICK_S * max(1, len(pids) // MANY_PIDS)
            story.stops.look(pids)
        if now_s >= self._machine_s:
            self._machine_s = now_s + MACHINE_S
            story.machine.append(self._machine.sample(now_s))
            story.delays.look(pids if story.observer is None else [*pids, story.observer])
        if now_s >= self._look_s and story.rows_s:  # whether a death is over, only rows say
            begin_s = time.thread_time()  # a busy machine is no reason to look less often
            self._look()
            took_s = time.thread_time() - begin_s
            self._look_s = now_s + max(LOOK_S, 20 * took_s)  # 5 % of a processor at most
        if self._probe is not None and not self._probe.is_alive:
            self._restart_probe()

    def _take_states(self) -> None:
        now_s = self._observations.now_s
        while not self._rows.empty():
            self._story.take_rows(self._rows.get(), now_s)
        while not self._graphs.empty():
            document = self._graphs.get()
            self._story.take_graph(document, self._observations.of_monotonic(document["mono"]))
            if self._parameters is not None:
                self._parameters.see(document["nodes"])

    def _look(self) -> None:
        story = self._story
        story.take(self._observations.take())
        story.facts = self._handover.unjudged(story.facts)
        if any(isinstance(event.event, Stopping) for event in story.facts.events):
            story.is_stopping = True
            return
        for trouble in story.facts.troubles:
            if trouble.startswith("cannot subscribe"):
                self._note(trouble)
        if self._topics is not None:
            self._topics.merge(story)
        if self._parameters is not None:
            self._parameters.take(story.facts.messages)
        self._table.look((*self._implied, *self._checks), story)
        self._table.end_mutes()
        changed = {one.number: one for one, _ in self._table.decide(story)}
        for incident in changed.values():
            self._files.opened(incident, story)
        for incident in self._table.closed(story.now_s):
            self._files.closed(incident, story)
        self._files.refresh(self._table.incidents, story)

    def _restart_probe(self) -> None:
        self._close_probe()
        if self._probe_starts < MAX_STARTS:
            self._note("the ROS probe has ended; it is started again")
            if self._story.now_s:  # else nothing is judged yet
                self._handover.resume(self._story.now_s)
            self._start_probe()
            self._story.now_s = self._observations.now_s
            self._story.begin_blind()
        else:
            self._note("the ROS probe has ended again; ROS is not observed any more")

    # ---- requests and reports

    def _take_requests(self) -> None:
        while not self._requests.empty():
            request = self._requests.get()
            match request.get("do"):
                case "stop":
                    self._story.is_stopping = True
                case "end":
                    self._is_over = True
                case what:
                    self._answer(what, request)

    def _answer(self, what: str, request: Mapping[str, Any]) -> None:
        name, reason = request["fault"], request.get("reason")
        fault: Fault | None
        try:
            if what == "acknowledge":
                fault = self._table.acknowledge(name, reason)
            elif what == "mute":
                for_s = request.get("for_s")
                until_s = None if for_s is None else time.time() + for_s
                fault = self._table.mute(name, reason, until_s)
            else:
                fault = self._table.unmute(name)
        except KeyError:
            self._say(id=request["id"], error=f"no fault '{name}'")
        else:
            self._keep_mute(name)
            document = fault and fault.document(self._observations.wall_of)
            changed = {} if document is None else {"fault": document, "change": "updated"}
            self._say(id=request["id"], mutes=self._table.mutes, **changed)

    def _keep_mute(self, name: str) -> None:
        """For later runs of the same launch file."""
        target, muted = self._settings.launch_file, self._table.mutes.get(name)
        if self._history is None:
            return
        if muted is None:
            self._history.clear_mute(target, name)
        else:
            self._history.set_mute(target, name, muted["reason"], muted["until_s"])

    def _report(self, fault: Fault, change: str) -> None:
        document = fault.document(self._observations.wall_of)
        if self._history is not None:
            self._history.record(document)
        self._say(fault=document, change=change)

    def _note(self, text: str) -> None:
        self._say(note=text)

    # ---- the end

    def _close_probe(self) -> None:
        for part in (self._topics, self._parameters):
            if part is not None:
                part.close()
        probe, self._probe, self._story.observer = self._probe, None, None
        if probe is not None:
            probe.close()

    def _end(self) -> None:
        """Write the incidents that are open, and end what was started."""
        closing = threading.Thread(target=self._close_probe, daemon=True)
        closing.start()
        for incident in self._table.incidents:
            if incident.closed_s is None:
                self._files.closed(incident, self._story)
        if self._history is not None:
            self._history.end_run()
        EVALUATOR.close()
        closing.join()


def _environment(run: Mapping[str, Any]) -> dict[str, str]:
    """Of the probe: it sees what the nodes of the run see."""
    env = {**os.environ, **run.get("discovery", {})}
    if run.get("domain_id") is not None:
        env["ROS_DOMAIN_ID"] = str(run["domain_id"])
    env.pop(RUN_ID_VARIABLE, None)
    return env


def _head(hello: Mapping[str, Any]) -> dict[str, Any]:
    run = {name: value for name, value in hello["run"].items() if name != "processes"}
    return {"run": run, "launcher": hello["launcher"], "ros": hello["ros"]}
