"""Helpers for the interpreter's tests: run entities and read their effects."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from launcher.base.model import events as model
from launcher.language.compat import vocabulary
from launcher.language.description import LaunchDescription
from launcher.language.interpreter import Interpreter


@contextmanager
def interpreting(entities: Sequence[Any], **options: Any) -> Iterator[Interpreter]:
    """An interpreter of these entities; closed in the end."""
    with vocabulary():
        interpreter = Interpreter(LaunchDescription(entities), **options)
        try:
            yield interpreter
        finally:
            interpreter.close()


def kinds(effects: Sequence[model.Effect]) -> list[str]:
    """The names of the effects' classes."""
    return [type(effect).__name__ for effect in effects]


def texts(effects: Sequence[model.Effect]) -> list[str]:
    """What LogInfo actions printed."""
    return [
        effect.text
        for effect in effects
        if isinstance(effect, model.LogMessage) and effect.logger == "launch.user"
    ]


def started(effects: Sequence[model.Effect]) -> list[model.StartProcess]:
    """The processes to start."""
    return [effect for effect in effects if isinstance(effect, model.StartProcess)]


def logged(*entities: Any, **options: Any) -> list[str]:
    """What the entities print when they are visited."""
    with interpreting(entities, **options) as interpreter:
        return texts(interpreter.start())


def notices(effects: Sequence[model.Effect]) -> list[str]:
    """Messages of the launcher itself."""
    return [
        effect.text
        for effect in effects
        if isinstance(effect, model.LogMessage) and effect.logger == "launch"
    ]
