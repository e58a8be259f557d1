"""The services of `bag play`, below `/rosbag2_player`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from launcher.bag.ros.control_services import ControlServices, answer, time_ns

if TYPE_CHECKING:
    from rclpy.node import Node

NODE = "rosbag2_player"
_NODE_TIME = 0
_INVALID_MODE, _INVALID_TOPIC = 1, 2


class Steered(Protocol):
    """What the services do with a player."""

    paused: bool
    rate: float

    def step(self, number: int) -> int:
        """Publish so many messages at once, 0: all, while it is paused; how many there were."""

    def seek(self, bag_ns: int) -> None: ...

    def stop(self) -> None: ...


class PlayerServices(ControlServices):
    """Of a player that is playing; when it ends, so do they."""

    def __init__(self, node: Node, player: Steered) -> None:
        self._player = player
        super().__init__(
            node,
            {
                "pause": ("Pause", self._pause),
                "resume": ("Resume", self._resume),
                "toggle_paused": ("TogglePaused", self._toggle),
                "is_paused": ("IsPaused", self._is_paused),
                "get_rate": ("GetRate", self._get_rate),
                "set_rate": ("SetRate", self._set_rate),
                "play": ("Play", self._play),
                "play_next": ("PlayNext", self._play_next),
                "burst": ("Burst", self._burst),
                "seek": ("Seek", self._seek),
                "stop": ("Stop", self._stop),
            },
        )

    def _pause(self, request: Any, response: Any) -> None:
        self._player.paused = True

    def _resume(self, request: Any, response: Any) -> None:
        if getattr(request, "resume_mode", _NODE_TIME) != _NODE_TIME:
            answer(response, "a player resumes by node time only", _INVALID_MODE)
        elif getattr(request, "tracking_topic_name", ""):
            answer(response, "a player tracks no topic", _INVALID_TOPIC)
        else:
            self._player.paused = False
            answer(response)

    def _toggle(self, request: Any, response: Any) -> None:
        self._player.paused = not self._player.paused

    def _is_paused(self, request: Any, response: Any) -> None:
        response.paused = self._player.paused

    def _get_rate(self, request: Any, response: Any) -> None:
        response.rate = self._player.rate

    def _set_rate(self, request: Any, response: Any) -> None:
        response.success = request.rate > 0
        if response.success:
            self._player.rate = request.rate

    def _play(self, request: Any, response: Any) -> None:
        response.success = False  # it is playing

    def _play_next(self, request: Any, response: Any) -> None:
        response.success = self._player.step(1) == 1

    def _burst(self, request: Any, response: Any) -> None:
        response.actually_burst = self._player.step(request.num_messages)

    def _seek(self, request: Any, response: Any) -> None:
        self._player.seek(time_ns(request, "time") or 0)
        response.success = True

    def _stop(self, request: Any, response: Any) -> None:
        self._player.stop()
        answer(response)
