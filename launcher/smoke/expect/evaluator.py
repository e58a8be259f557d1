"""Evaluates the conditions of expectations in a process with limits of time and memory."""

from __future__ import annotations

import atexit
import contextlib
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from launcher.base import strict_json
from launcher.base.model.run_event import exit_text
from launcher.smoke.expect.evaluation import CPU_S, MEMORY_BYTES, OUT_OF_MEMORY, EvaluatedCondition

Judged = tuple[bool, str | None]  # whether all conditions hold, and why not

BATCH = 50  # contents that are sent at once
WALL_S = 60.0  # a batch, on a machine that has no CPU time for it
_REASONS = {
    -int(signal.SIGPROF): f"takes more than {CPU_S:g} s of CPU time",
    -int(signal.SIGKILL): f"takes more than {WALL_S:g} s, or was killed",
    OUT_OF_MEMORY: f"takes more than {MEMORY_BYTES // 1024**2} MB of memory",
}


class TooExpensiveError(Exception):
    """Conditions that exceed a limit; the text names them and the limit."""


class NotYetError(Exception):
    """The evaluation goes on; a later call has the results."""


class Evaluator:
    """One process for all conditions, from the first use to `close`; for any thread.

    Results are kept: a content is judged once by the same conditions, whatever is asked how often.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        # By pickled conditions, and by the identity of a content, which is kept with its result.
        self._known: dict[bytes, dict[int, tuple[Any, Judged]]] = {}
        self._refused: dict[bytes, str] = {}

    def judged(
        self,
        conditions: Sequence[EvaluatedCondition],
        contents: Sequence[Any],
        patience_s: float | None = None,
    ) -> list[Judged]:
        """One for each content; TooExpensiveError, from then on at once.

        NotYetError after `patience_s`; None waits for the results, whose time is limited.
        """
        if not conditions:
            return [(True, None)] * len(contents)
        key = pickle.dumps(conditions)
        known = self._known.setdefault(key, {})
        if any(id(one) not in known for one in contents) and key not in self._refused:
            self._in_thread(lambda: self._evaluate(key, known, conditions, contents), patience_s)
        if (refusal := self._refused.get(key)) is not None:
            raise TooExpensiveError(refusal)
        if any(id(one) not in known for one in contents):
            raise NotYetError  # closed meanwhile
        return [known[id(one)][1] for one in contents]

    def forget(
        self, conditions: Sequence[EvaluatedCondition], contents: Sequence[Any] = ()
    ) -> None:
        """Forget the results for these contents, of which nobody asks again.

        It waits for no evaluation that goes on, and leaves the results of others.
        """
        known = self._known.get(pickle.dumps(conditions), {})
        for content in contents:
            known.pop(id(content), None)

    def _in_thread(self, work: Callable[[], None], patience_s: float | None) -> None:
        """An interrupt ends the waiting, and not what the process is asked; NotYetError."""
        if not self._lock.acquire(timeout=-1 if patience_s is None else patience_s):
            raise NotYetError
        errors: list[Exception] = []

        def run() -> None:
            try:
                work()
            except Exception as error:
                errors.append(error)
            finally:
                self._lock.release()

        thread = threading.Thread(target=run, daemon=True, name="evaluator")
        thread.start()
        thread.join(patience_s)
        if thread.is_alive():
            raise NotYetError
        if errors:
            raise errors[0]

    def _evaluate(
        self,
        key: bytes,
        known: dict[int, tuple[Any, Judged]],
        conditions: Sequence[EvaluatedCondition],
        contents: Sequence[Any],
    ) -> None:
        """Add the results that are not known."""
        new = [one for one in contents if id(one) not in known]
        for number in range(0, len(new), BATCH):
            if key in self._refused:
                return
            batch = new[number : number + BATCH]
            for content, result in zip(batch, self._asked(key, conditions, batch), strict=True):
                known[id(content)] = content, result

    def close(self) -> None:
        """End the process and forget the results; the next use starts anew."""
        process = self._process
        if process is not None:
            process.kill()  # it may be in the middle of an evaluation
        with self._lock:
            self._known.clear()
            self._refused.clear()
            self._end()

    def _asked(
        self, key: bytes, conditions: Sequence[EvaluatedCondition], batch: Sequence[Any]
    ) -> list[Judged]:
        try:
            with self._bounded() as process:
                assert process.stdin is not None
                assert process.stdout is not None
                with contextlib.suppress(BrokenPipeError):
                    pickle.dump((conditions, [*map(pickle.dumps, batch)]), process.stdin)
                    process.stdin.flush()
                answer = process.stdout.readline()
        except BaseException:
            self._end()  # it would answer the next request with this one's results
            raise
        if answer.endswith(b"\n"):
            return [(holds, why) for holds, why in strict_json.unpacked(answer)]
        code = process.wait()
        self._end()
        text = " and ".join(one.text for one in conditions)
        reason = _REASONS.get(code, f"ends its process ({exit_text(code)})")
        self._refused[key] = f"the evaluation of '{text}' {reason}"
        return [(False, None)] * len(batch)

    @contextlib.contextmanager
    def _bounded(self) -> Iterator[subprocess.Popen[bytes]]:
        """The process, which is killed if the body takes too long."""
        if self._process is None:
            self._process = _start()
        timer = threading.Timer(WALL_S, self._process.kill)
        timer.daemon = True
        timer.start()
        try:
            yield self._process
        finally:
            timer.cancel()

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout, process.stderr):
            assert pipe is not None
            with contextlib.suppress(BrokenPipeError):
                pipe.close()


def _start() -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "launcher.smoke.expect.evaluation"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,  # see `evaluation`
    )


EVALUATOR = Evaluator()
atexit.register(EVALUATOR.close)
