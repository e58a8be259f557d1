"""A new evaluation, brought to the moment of a run: what containers and their nodes are asked."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Sequence

from launcher.base.model import events as model
from launcher.base.model.lifecycle_transitions import transition_steps
from launcher.base.model.reload_changes import Known, Reload
from launcher.base.model.spec import ProcessSpec
from launcher.base.model.spec_diff import comparable
from launcher.language.actions.event_actions import LogInfo, OpaqueFunction, RegisterEventHandler
from launcher.language.actions.process import ExecuteProcess, OnProcessStart
from launcher.language.actions.timer import TimerAction
from launcher.language.compat import vocabulary
from launcher.language.context import LaunchContext
from launcher.language.description import LaunchDescription
from launcher.language.interpreter import Interpreter
from launcher.language.interpreter.replay import Replay, Requests
from launcher.language.ros.composable_lifecycle import ComposableLifecycleNode
from launcher.language.ros.composition import ComposableNode, ComposableNodeContainer
from tests.language.unit.interpreter.interpreting import notices, started

PUMP = "Pump"  # the plug-in of a lifecycle node


def container(*plugins: str) -> LaunchDescription:
    nodes: list[ComposableNode] = [
        ComposableLifecycleNode(package="p", plugin=one, name=one.lower(), autostart=True)
        if one == PUMP
        else ComposableNode(package="p", plugin=one, name=one.lower())
        for one in plugins
    ]
    action = ComposableNodeContainer(
        executable="/bin/cat", name="box", namespace="", composable_node_descriptions=nodes
    )
    return LaunchDescription([action])


def run_of(description: LaunchDescription) -> tuple[list[Known], list[Requests]]:
    """The container of a run, in which all requests to nodes have succeeded."""
    interpreter = Interpreter(description)
    queue = deque(interpreter.start())
    (process,) = started(list(queue))
    requests: list[Requests] = []
    while queue:
        match queue.popleft():
            case model.LoadComponent(request_id=number, request=load):
                requests.append(load)
                queue += interpreter.handle(model.ComponentLoaded(number))
            case model.ChangeState(request_id=number, request=change):
                requests.append(change)
                queue += interpreter.handle(model.StateChanged(number))
                for step in transition_steps(change.transition_id):
                    queue += interpreter.handle(model.TransitionSeen(change.node, *step))
    spec = process.spec
    known = Known(process.process_id, spec.name, comparable(spec), has_started=True, pid=7)
    interpreter.close()
    return [known], requests


def replayed(before: Sequence[str], after: Sequence[str]) -> tuple[Reload, Interpreter, Replay]:
    with vocabulary():
        known, done = run_of(container(*before))
        interpreter = Interpreter(container(*after))
        replay = Replay(
            interpreter,
            known,
            done=done,
            said=(),
            adapt=lambda spec: spec,
            numbered=1,
        )
        reload = replay.run(100.0)
        interpreter.close()
        return reload, interpreter, replay


def transitions(effects: Sequence[model.Effect]) -> list[str]:
    return [one.request.transition for one in effects if isinstance(one, model.ChangeState)]


def plugins(effects: Sequence[model.Effect]) -> list[str]:
    return [one.request.plugin for one in effects if isinstance(one, model.LoadComponent)]


def after_restart(reload: Reload) -> list[model.LoadComponent]:
    """What is loaded into the only container when it runs again; nothing else is."""
    assert [one.changes for one in reload.kept] == [("components",)]
    assert plugins(reload.effects) == []
    ((_, after),) = reload.after
    return [one for one in after if isinstance(one, model.LoadComponent)]


def test_nodes_that_are_loaded_are_not_loaded_again():
    reload, _, replay = replayed(["A", "B"], ["A", "B"])
    assert (reload.is_empty, plugins(reload.effects), reload.after) == (True, [], ())
    assert (plugins(replay.repeated), replay.started) == (["A", "B"], set())


def test_a_container_with_other_nodes_is_restarted_and_loads_them_when_it_runs():
    reload, interpreter, replay = replayed(["A", "B"], ["A", "C", "D"])
    first, second = after_restart(reload)
    assert plugins([first, second]) == ["A", "C"]
    assert interpreter.handle(model.ComponentLoaded(first.request_id, "/a")) == []
    # D follows when C is loaded.
    assert plugins(interpreter.handle(model.ComponentLoaded(second.request_id, "/c"))) == ["D"]
    assert (replay.started, replay.repeated) == ({1}, [])


def test_a_container_without_one_of_its_nodes_is_restarted():
    reload, interpreter, _ = replayed(["A", "B"], ["A"])
    (load,) = after_restart(reload)
    failed = model.ComponentLoaded(load.request_id, error="no such plugin")
    assert notices(interpreter.handle(failed)) == [
        "Failed to load node 'a' of type 'A' again: no such plugin"
    ]


def test_a_container_is_evaluated_once_when_its_nodes_have_changed():
    calls = []

    def more(context: LaunchContext) -> list[LogInfo]:
        calls.append(context)
        return [LogInfo(msg="it runs")]

    with vocabulary():
        known, loads = run_of(container("A", "B"))
        box = container("A").entities[0]
        handler = OnProcessStart(target_action=box, on_start=[OpaqueFunction(function=more)])
        interpreter = Interpreter(LaunchDescription([RegisterEventHandler(handler), box]))
        replay = Replay(
            interpreter, known, done=loads, said=(), adapt=lambda spec: spec, numbered=1
        )
        reload = replay.run(100.0)
        interpreter.close()

    assert plugins(after_restart(reload)) == ["A"]
    assert len(calls) == 1 and replay.started == {1}


def test_a_component_that_is_active_is_not_activated_again():
    reload, _, replay = replayed(["A", PUMP], ["A", PUMP])
    assert (transitions(reload.effects), reload.after) == ([], ())
    assert transitions(replay.repeated) == ["configure", "activate"]


def test_a_component_is_activated_again_with_its_container():
    reload, _, _ = replayed(["A", PUMP], [PUMP])
    ((_, after),) = reload.after
    assert [type(one) for one in after] == [model.LoadComponent, *[model.ChangeState] * 2]
    assert transitions(reload.effects) == []


def test_timers_of_an_event_count_from_the_event():
    with vocabulary():
        program = ExecuteProcess(cmd=["cat"])
        timer = TimerAction(period=5.0, actions=[ExecuteProcess(cmd=["true"])])
        handler = RegisterEventHandler(OnProcessStart(target_action=program, on_start=[timer]))
        interpreter = Interpreter(LaunchDescription([program, handler]))
        spec = ProcessSpec(name="cat-1", label="cat", argv=("cat",), env=dict(os.environ))
        known = Known(7, "cat-1", comparable(spec), has_started=True, started_ago_s=2.0, pid=1)
        replay = Replay(interpreter, [known], done=[], said=(), adapt=lambda spec: spec, numbered=1)
        reload = replay.run(100.0)
        interpreter.close()
    assert [one.delay_s for one in reload.effects if isinstance(one, model.CallLater)] == [3.0]
    assert not reload.new
