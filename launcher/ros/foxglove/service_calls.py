"""Calls of services from the event loop; rclpy's executor takes the answers in a thread."""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from typing import TYPE_CHECKING, Any

from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor

from launcher.base.ros_errors import VerbError
from launcher.ros.discovery.observer import Observer
from launcher.ros.messages.classes import with_library
from launcher.ros.service_caller import ASK_AGAIN_S

if TYPE_CHECKING:
    from rclpy.client import Client

_PERIOD_S = 0.02
_READY_S = 3.0  # from the discovery of a service until its client is connected
_DISCOVERED_S = 0.2  # a younger participant may not be known to a service, which drops its answer


class ServiceCalls:
    """`worker` runs what changes endpoints; close it before the observer."""

    def __init__(self, observer: Observer, worker: Executor) -> None:
        self._observer = observer
        self._worker = worker
        self._node = observer.helper("calls")
        self._executor = SingleThreadedExecutor(context=observer.context)
        self._executor.add_node(self._node)
        self._clients: dict[str, tuple[Any, asyncio.Future[Any]]] = {}
        self._thread = threading.Thread(target=self._spin, name="calls", daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            self._executor.spin()

    def close(self) -> None:
        self._executor.shutdown()
        self._thread.join()
        self._node.destroy_node()

    async def work(self, function: Callable[..., Any], *words: object) -> Any:
        """Run what changes endpoints, in the thread for it."""
        return await asyncio.get_running_loop().run_in_executor(self._worker, function, *words)

    def forget(self, names: set[str]) -> None:
        """Give up the clients of services that are gone: they would keep the services listed."""
        for name in names & self._clients.keys():
            _, created = self._clients.pop(name)
            if created.done() and not created.cancelled() and created.exception() is None:
                self._worker.submit(self._node.destroy_client, created.result())

    async def call(self, kind: object, name: str, request: object) -> Any:
        """The answer, whenever it comes; VerbError if the service is not there, or vanishes."""
        with _vanishing(name):
            client = await self._connected(kind, name)
            answer, abandon = self._send(client, request)
            try:
                while not (await asyncio.wait([answer], timeout=1.0))[0]:
                    if not client.service_is_ready():
                        raise _vanished(name)
                return answer.result()
            finally:
                abandon()

    async def ask(self, kind: object, name: str, request: object, limit_s: float) -> Any:
        """The answer, asked for repeatedly since it may be lost; VerbError after the limit.

        For requests that may be carried out twice.
        """
        with _vanishing(name):
            return await self._ask(kind, name, request, limit_s)

    async def _ask(self, kind: object, name: str, request: object, limit_s: float) -> Any:
        client = await self._connected(kind, name)
        deadline = time.monotonic() + limit_s
        sent: list[tuple[asyncio.Future[Any], Callable[[], None]]] = []
        try:
            while (left_s := deadline - time.monotonic()) > 0:
                sent.append(self._send(client, request))
                answers = [answer for answer, _ in sent]
                done, _ = await asyncio.wait(
                    answers,
                    timeout=min(left_s, ASK_AGAIN_S),
                    return_when=asyncio.FIRST_COMPLETED,
                )
                if done:
                    return done.pop().result()
            raise VerbError(f"service '{name}' did not answer within {limit_s:g} s")
        finally:
            for _, abandon in sent:
                abandon()

    async def _connected(self, kind: object, name: str) -> Any:
        client = await self._client(kind, name)
        deadline = time.monotonic() + _READY_S
        while not client.service_is_ready():
            if time.monotonic() > deadline:
                raise VerbError(f"service '{name}' is not available")
            await asyncio.sleep(_PERIOD_S)
        young_s = self._observer.created_s + _DISCOVERED_S - time.monotonic()
        await asyncio.sleep(max(0.0, young_s))
        return client

    async def _client(self, kind: object, name: str) -> Any:
        known = self._clients.get(name)
        if known is None or known[0] is not kind:
            creation = asyncio.ensure_future(self.work(self._create, kind, name))
            known = self._clients[name] = (kind, creation)
        try:
            return await asyncio.shield(known[1])
        except VerbError:
            self._clients.pop(name, None)
            raise

    def _create(self, kind: object, name: str) -> Any:
        return self._node.create_client(with_library(kind), name)

    def _send(
        self, client: Client, request: object
    ) -> tuple[asyncio.Future[Any], Callable[[], None]]:
        """The answer, and what to call when nobody waits for it any more."""
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[Any] = loop.create_future()
        future = client.call_async(request)
        future.add_done_callback(lambda done: _pass_on(loop, answer, done))

        def abandon() -> None:
            answer.cancel()
            client.remove_pending_request(future)

        return answer, abandon


@contextlib.contextmanager
def _vanishing(name: str) -> Iterator[None]:
    """VerbError if the client of a service is destroyed meanwhile, as `forget` does."""
    try:
        yield
    except InvalidHandle:
        raise _vanished(name) from None


def _vanished(name: str) -> VerbError:
    return VerbError(f"service '{name}' has vanished before it answered")


def _pass_on(loop: asyncio.AbstractEventLoop, answer: asyncio.Future[Any], done: Any) -> None:
    """In the thread of the executor."""

    def settle() -> None:
        if not answer.done():
            answer.set_result(done.result())

    if not loop.is_closed():
        loop.call_soon_threadsafe(settle)
