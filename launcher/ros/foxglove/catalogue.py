"""The channels and services that are offered to clients, under numbers that are never reused."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import count

from launcher.base.ros_errors import VerbError
from launcher.ros.foxglove.protocol import AdvertisedService, Channel


@dataclass(slots=True)
class CatalogueChange:
    """What is new and what has gone."""

    channels: list[Channel] = field(default_factory=list)
    gone_channels: list[Channel] = field(default_factory=list)
    services: list[AdvertisedService] = field(default_factory=list)
    gone_services: list[AdvertisedService] = field(default_factory=list)


class Catalogue:
    """`schema_of` gives the text of a type, or raises VerbError; `warn` is called once for
    each text.

    A topic has one channel: clients refuse a second one. Of several types it is the first one
    whose definition is installed.
    """

    def __init__(self, schema_of: Callable[[str], str], warn: Callable[[str], None]) -> None:
        self._schema_of = schema_of
        self._warn = warn
        self._numbers = count(1)
        self._warned: set[str] = set()
        self._channels: dict[str, Channel] = {}
        self._services: dict[str, AdvertisedService] = {}

    @property
    def channels(self) -> list[Channel]:
        return list(self._channels.values())

    @property
    def services(self) -> list[AdvertisedService]:
        return list(self._services.values())

    def channel(self, number: int) -> Channel | None:
        return next((one for one in self._channels.values() if one.id == number), None)

    def service(self, number: int) -> AdvertisedService | None:
        return next((one for one in self._services.values() if one.id == number), None)

    def update(
        self, topics: Mapping[str, tuple[str, ...]], services: Mapping[str, str]
    ) -> CatalogueChange:
        """Offer these, and no others."""
        change = CatalogueChange()
        for topic, channel in list(self._channels.items()):
            if channel.type not in topics.get(topic, ()):
                change.gone_channels.append(self._channels.pop(topic))
        for name, service in list(self._services.items()):
            if service.type != services.get(name):
                change.gone_services.append(self._services.pop(name))
        for topic, types in topics.items():
            if topic not in self._channels and (new := self._new_channel(topic, types)):
                self._channels[topic] = new
                change.channels.append(new)
        for name, type_name in services.items():
            if name not in self._services and (offered := self._new_service(name, type_name)):
                self._services[name] = offered
                change.services.append(offered)
        return change

    def _new_channel(self, topic: str, types: tuple[str, ...]) -> Channel | None:
        for type_name in types:
            if (schema := self._schema(topic, type_name)) is not None:
                if len(types) > 1:
                    others = ", ".join(other for other in types if other != type_name)
                    self._warn_once(f"{topic} is shown as {type_name}, and not as {others}")
                return Channel(next(self._numbers), topic, type_name, schema)
        return None

    def _new_service(self, name: str, type_name: str) -> AdvertisedService | None:
        request = self._schema(name, f"{type_name}_Request")
        response = self._schema(name, f"{type_name}_Response")
        if request is None or response is None:
            return None
        return AdvertisedService(next(self._numbers), name, type_name, request, response)

    def _schema(self, name: str, type_name: str) -> str | None:
        try:
            return self._schema_of(type_name)
        except VerbError as error:
            hint = f"; {error.hint}" if error.hint else ""
            self._warn_once(f"{name} is not shown: {error.message}{hint}")
            return None

    def _warn_once(self, text: str) -> None:
        if text not in self._warned:
            self._warned.add(text)
            self._warn(text)
