"""Lifecycle nodes that are activated by themselves, as processes and as components."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from launcher.base.errors import LaunchFileError
from launcher.base.model import events as model
from launcher.language.actions.event_actions import (
    EmitEvent,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
)
from launcher.language.actions.group import GroupAction
from launcher.language.conditions import IfCondition
from launcher.language.ros.composable_lifecycle import ComposableLifecycleNode
from launcher.language.ros.composition import ComposableNode, LoadComposableNodes
from launcher.language.ros.lifecycle import (
    ChangeState,
    LifecycleNode,
    OnStateTransition,
    StateTransition,
    matches_node_name,
)
from launcher.language.ros.node import Node
from launcher.language.ros.scope import PushROSNamespace
from launcher.language.substitutions.configuration import LaunchConfiguration
from tests.language.unit.interpreter.interpreting import interpreting, started, texts

STEPS = {
    "configure": (("unconfigured", "configuring"), ("configuring", "inactive")),
    "activate": (("inactive", "activating"), ("activating", "active")),
}


def lifecycle_node(**options: Any) -> LifecycleNode:
    return LifecycleNode(name="n", namespace="ns", executable="exe", **options)


def component(**options: Any) -> ComposableLifecycleNode:
    given = {"package": "p", "plugin": "P", "name": "n", "namespace": "ns", **options}
    return ComposableLifecycleNode(**given)


def load(*nodes: ComposableNode) -> LoadComposableNodes:
    return LoadComposableNodes(target_container="/box", composable_node_descriptions=list(nodes))


def requested(effects: Sequence[model.Effect]) -> list[tuple[str, str]]:
    """(node, transition) of each request."""
    found = [one.request for one in effects if isinstance(one, model.ChangeState)]
    return [(one.node, one.transition) for one in found]


def watched(effects: Sequence[model.Effect]) -> list[str]:
    return [one.node for one in effects if isinstance(one, model.WatchLifecycle)]


def lines(effects: Sequence[model.Effect]) -> list[str]:
    return [one.text for one in effects if isinstance(one, model.LogMessage)]


def make(interpreter: Any, label: str) -> list[model.Effect]:
    """What follows when the node reports the steps of this transition."""
    effects: list[model.Effect] = []
    for start, goal in STEPS[label]:
        effects += interpreter.handle(model.TransitionSeen("/ns/n", label, start, goal, 5))
    return effects


def loaded(interpreter: Any, effects: Sequence[model.Effect], error: str | None = None) -> Any:
    (effect,) = [one for one in effects if isinstance(one, model.LoadComponent)]
    name = "" if error else "/ns/n"
    return interpreter.handle(model.ComponentLoaded(effect.request_id, name, 1, error))


# ---- LifecycleNode


@pytest.mark.parametrize("autostart", [True, LaunchConfiguration("x", default="true")])
def test_autostart_configures_and_then_activates_the_node(autostart: object):
    with interpreting([lifecycle_node(autostart=autostart)]) as interpreter:
        effects = interpreter.start()
        assert len(started(effects)) == 1
        assert watched(effects) == ["/ns/n"]
        assert requested(effects) == [("/ns/n", "configure")]
        assert requested(make(interpreter, "configure")) == [("/ns/n", "activate")]
        assert requested(make(interpreter, "activate")) == []


@pytest.mark.parametrize("given", [{}, {"autostart": LaunchConfiguration("x", default="0")}])
def test_without_autostart_nothing_is_requested(given: dict[str, Any]):
    with interpreting([lifecycle_node(**given)]) as interpreter:
        assert requested(interpreter.start()) == []


def test_a_text_is_no_truth_value():
    with pytest.raises(TypeError, match="bool"):
        lifecycle_node(autostart="true")


def test_autostart_gives_up_at_a_failure_and_the_launch_goes_on():
    with interpreting([lifecycle_node(autostart=True)]) as interpreter:
        (request,) = [one for one in interpreter.start() if isinstance(one, model.ChangeState)]
        failed = interpreter.handle(model.StateChanged(request.request_id, error="refused"))
        back = interpreter.handle(
            model.TransitionSeen("/ns/n", "failure", "configuring", "unconfigured")
        )
        assert lines(failed) == [
            "Failed to make transition 'TRANSITION_CONFIGURE' for LifecycleNode '/ns/n'"
        ]
        assert (requested(back), interpreter.failure) == ([], None)


def test_autostart_gives_up_at_an_error():
    with interpreting([lifecycle_node(autostart=True)]) as interpreter:
        interpreter.start()
        seen = model.TransitionSeen("/ns/n", "error", "configuring", "errorprocessing")
        (line,) = lines(interpreter.handle(seen))
        assert line == (
            "Stopping transitions for /ns/n because 'error occurred during transitions'"
        )
        assert requested(make(interpreter, "configure")) == []


# ---- ComposableLifecycleNode


def test_a_component_is_activated_once_it_is_loaded():
    node = component(autostart=True)
    with interpreting([load(node)]) as interpreter:
        effects = interpreter.start()
        assert watched(effects) == ["/ns/n"]
        assert "Autostart enabled for requested lifecycle node /ns/n" in lines(effects)
        assert requested(effects) == []
        assert requested(loaded(interpreter, effects)) == [("/ns/n", "configure")]
        assert requested(make(interpreter, "configure")) == [("/ns/n", "activate")]
    assert node.node_name == "/ns/n"


def test_the_name_is_that_of_the_scope():
    nodes = load(component(autostart=LaunchConfiguration("x", default="true")))
    with interpreting([GroupAction([PushROSNamespace("top"), nodes])]) as interpreter:
        effects = interpreter.start()
        assert watched(effects) == ["/top/ns/n"]
        (effect,) = [one for one in effects if isinstance(one, model.LoadComponent)]
        assert (effect.request.namespace, effect.request.name) == ("/top/ns", "n")


def test_a_component_that_cannot_be_loaded_is_asked_for_nothing():
    with interpreting([load(component(autostart=True))]) as interpreter:
        effects = loaded(interpreter, interpreter.start(), error="no plug-in P")
        assert requested(effects) == []
        assert not interpreter.host.waiting


def test_a_component_behind_a_false_condition_is_not_watched():
    node = component(autostart=True, condition=IfCondition("false"))
    with interpreting([load(node)]) as interpreter:
        effects = interpreter.start()
        assert (watched(effects), requested(effects)) == ([], [])
        assert not any("Autostart" in line for line in lines(effects))


def test_a_component_without_a_name_cannot_be_activated():
    nodes = load(component(name=None, autostart=True))
    refused = pytest.raises(LaunchFileError, match="needs a name")
    with interpreting([nodes]) as interpreter, refused:
        interpreter.start()


def test_a_component_without_a_name_is_watched_when_it_has_one():
    with interpreting([load(component(name=None))]) as interpreter:
        effects = interpreter.start()
        assert watched(effects) == []
        assert watched(loaded(interpreter, effects)) == ["/ns/n"]


def test_events_change_a_component_that_is_loaded():
    change = ChangeState(lifecycle_node_matcher=matches_node_name("/ns/n"), transition_id=1)
    with interpreting([load(component()), EmitEvent(event=change)]) as interpreter:
        effects = interpreter.start()
        assert requested(effects) == []
        assert requested(loaded(interpreter, effects)) == [("/ns/n", "configure")]


def test_a_handler_waits_for_a_component():
    node = component(autostart=True)
    handler = OnStateTransition(
        target_lifecycle_node=node, goal_state="inactive", entities=[LogInfo(msg="ready")]
    )
    other = OnStateTransition(target_lifecycle_node=component(), entities=[LogInfo(msg="no")])
    handlers = [RegisterEventHandler(handler), RegisterEventHandler(other)]
    with interpreting([*handlers, load(node)]) as interpreter:
        loaded(interpreter, interpreter.start())
        assert texts(make(interpreter, "configure")) == ["ready"]


# ---- handlers and events


class Disabled(LifecycleNode):
    @property
    def is_lifecycle_node(self) -> bool:
        return False


@pytest.mark.parametrize(
    ("target", "end"),
    [
        (Node(executable="e"), "is not a lifecycle-enabled node type."),
        (ComposableNode(package="p", plugin="P"), "is not a lifecycle-enabled node type."),
        (Disabled(name="n", namespace="", executable="e"), "is not lifecycle-enabled."),
    ],
)
def test_a_handler_is_for_lifecycle_nodes(target: Any, end: str):
    with pytest.raises(RuntimeError) as caught:
        OnStateTransition(target_lifecycle_node=target, entities=[])
    start = "OnStateTransition requires a lifecycle enabled node as the target, "
    assert str(caught.value) == f"{start}target_lifecycle_node {end}"


def test_an_event_has_its_time_in_both_forms():
    found: list[tuple[int, int, int]] = []

    def note(context: Any) -> None:
        event = context.locals.event
        found.append((event.timestamp, event.stamp.sec, event.stamp.nanosec))

    handler = OnStateTransition(goal_state="active", entities=[OpaqueFunction(function=note)])
    with interpreting([RegisterEventHandler(handler), lifecycle_node()]) as interpreter:
        interpreter.start()
        seen = model.TransitionSeen("/ns/n", "t", "activating", "active", 3_000_000_007)
        interpreter.handle(seen)
    assert found == [(3_000_000_007, 3, 7)]


@pytest.mark.parametrize(
    "time", [{"timestamp": 1_000_000_002}, {"stamp": SimpleNamespace(sec=1, nanosec=2)}]
)
def test_an_event_is_made_of_the_message_of_any_release(time: dict[str, Any]):
    label = SimpleNamespace(label="x")
    message = SimpleNamespace(transition=label, start_state=label, goal_state=label, **time)
    event = StateTransition(action=None, msg=message)
    assert (event.timestamp, event.stamp.sec, event.stamp.nanosec) == (1_000_000_002, 1, 2)
