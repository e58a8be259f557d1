"""`tf monitor`: delays and rates of frames and of the nodes that broadcast them."""

from __future__ import annotations

import math
import sys
import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from statistics import fmean
from typing import Any

from launcher.posix.json_output import print_line
from launcher.ros.tf.frame_buffer import TfError, TransformBuffer
from launcher.ros.tf.frame_tree import TfSample
from launcher.ros.tf.tf_echo import WAITING_S, waiting

_WINDOW = 1000
_REPORT_S = 10.0
_NET_S = 0.5
_UNKNOWN = "<no authority available>"


class _Window(deque[float]):
    """The last numbers: delays, or times in seconds."""

    def __init__(self) -> None:
        super().__init__(maxlen=_WINDOW)

    @property
    def mean(self) -> float:
        return fmean(self) if self else 0.0

    @property
    def most(self) -> float:
        return max(self, default=0.0)

    @property
    def rate_hz(self) -> float:
        span_s = self[-1] - self[0]
        return (len(self) - 1) / span_s if span_s > 0.0 else 0.0


class DelayStatistics:
    """Of all frames, and of the way between two."""

    def __init__(self) -> None:
        self._delays: dict[str, _Window] = {}
        self._node_of: dict[str, str] = {}
        self._node_delays: dict[str, _Window] = {}
        self._arrivals: dict[str, _Window] = {}
        self._net = _Window()

    def take(self, sample: TfSample, now_ns: int) -> None:
        node = sample.broadcaster or _UNKNOWN
        delays = [(now_ns - stamped.stamp_ns) / 1e9 for stamped in sample.transforms]
        for stamped, delay_s in zip(sample.transforms, delays, strict=True):
            self._node_of[stamped.child] = node
            self._delays.setdefault(stamped.child, _Window()).append(delay_s)
        self._node_delays.setdefault(node, _Window()).append(fmean(delays) if delays else 0.0)
        self._arrivals.setdefault(node, _Window()).append(now_ns / 1e9)

    def take_net_delay(self, delay_s: float) -> None:
        """The age of the transform between the two frames."""
        self._net.append(delay_s)

    def lines(self, chain: Sequence[str]) -> Iterator[str]:
        """A report as tf2_monitor prints it; `chain` is empty for all frames."""
        yield "\n\n"
        if chain:
            net = self._net
            yield f"RESULTS: for {chain[0]} to {chain[-1]}"
            yield f"Chain is: {' -> '.join(chain)}"
            yield f"Net delay     avg = {net.mean:g}: max = {max(0.0, net.most):g}"
        else:
            yield "RESULTS: for all Frames"
        yield "\nFrames:"
        for frame in self._shown(chain):
            delays = self._delays[frame]
            yield (
                f"Frame: {frame}, published by {self._node_of[frame]}, "
                f"Average Delay: {delays.mean:g}, Max Delay: {max(0.0, delays.most):g}"
            )
        yield "\nAll Broadcasters:"
        for node, delays in sorted(self._node_delays.items()):
            yield (
                f"Node: {node} {self._arrivals[node].rate_hz:g} Hz, "
                f"Average Delay: {delays.mean:g} Max Delay: {max(0.0, delays.most):g}"
            )

    def _shown(self, chain: Iterable[str]) -> list[str]:
        wanted = set(chain) or self._delays.keys()
        return sorted(frame for frame in self._delays if frame in wanted)

    def document(self, chain: Sequence[str]) -> dict[str, Any]:
        return {
            "chain": list(chain),
            "net_delay": _document(self._net) if chain else None,
            "frames": [
                {
                    "frame": frame,
                    "broadcaster": _known(self._node_of[frame]),
                    **_document(self._delays[frame]),
                }
                for frame in self._shown(chain)
            ],
            "broadcasters": [
                {"node": _known(node), "rate_hz": self._arrivals[node].rate_hz, **_document(delays)}
                for node, delays in sorted(self._node_delays.items())
            ],
        }


def _document(delays: _Window) -> dict[str, float]:
    return {"mean_delay_s": delays.mean, "max_delay_s": delays.most}


def _known(node: str) -> str | None:
    return None if node == _UNKNOWN else node


class TfMonitor:
    """Prints a report every ten seconds; `frames` are two, or none for all.

    Its caller ends it after `for_s`.
    """

    def __init__(self, frames: Sequence[str], *, json: bool, for_s: float | None = None) -> None:
        self.has_data = False
        self._frames = tuple(frames)
        self._json = json
        self._first_s = _REPORT_S if for_s is None else min(for_s, _REPORT_S)
        self._buffer = TransformBuffer()
        self._statistics = DelayStatistics()
        self._chain: tuple[str, ...] = ()
        self._waiting_s = -math.inf
        self._net_s = self._report_s = math.inf

    def take(self, sample: TfSample, now_ns: int) -> None:
        self.has_data = True
        self._statistics.take(sample, now_ns)
        for stamped in sample.transforms:
            self._buffer.add(stamped, is_static=sample.is_static)

    def step(self, now_ns: int, elapsed_s: float) -> None:
        """Print what is due."""
        if self._report_s == math.inf and not self._begin(now_ns, elapsed_s):
            return
        if self._chain and elapsed_s >= self._net_s:
            self._net_s += _NET_S
            self._take_net(now_ns)
        if elapsed_s >= self._report_s:
            self._report_s += _REPORT_S
            self.report()

    def why_not(self) -> str | None:
        """Why there has been no way between the two frames; None if there is nothing to say."""
        if not self._frames or self._chain:
            return None
        one, other = self._frames
        return self._buffer.why_not(one, other) or "it came too late"

    def _begin(self, now_ns: int, elapsed_s: float) -> bool:
        """Whether the way between the two frames is known."""
        if self._frames:
            one, other = self._frames
            why = self._buffer.why_not(one, other)
            if why is not None:
                if self._waiting_s == -math.inf:
                    self._waiting_s = elapsed_s + WAITING_S
                if elapsed_s >= self._waiting_s:
                    self._waiting_s = elapsed_s + WAITING_S
                    line = waiting("tf2_monitor_main", one, other, why, now_ns)
                    print(line, file=sys.stderr, flush=True)
                return False
            self._chain = self._buffer.chain(other, one)
        what = " -> ".join(self._frames) or "all frames"
        if not self._json:
            print(f"Gathering data on {what} for {self._first_s:g} seconds...", flush=True)
        self._net_s, self._report_s = elapsed_s, elapsed_s + _REPORT_S
        return True

    def _take_net(self, now_ns: int) -> None:
        one, other = self._frames
        try:
            stamp_ns = self._buffer.lookup(one, other).stamp_ns
        except TfError:
            return  # the frames are not connected any more
        # between static frames a transform has no age
        self._statistics.take_net_delay((now_ns - stamp_ns) / 1e9 if stamp_ns else 0.0)

    def report(self) -> None:
        if self._json:
            print_line({"wall_s": time.time(), **self._statistics.document(self._chain)})
        else:
            print("\n".join(self._statistics.lines(self._chain)), flush=True)
