"""A new evaluation, brought to the moment of a run: what containers and their nodes are asked."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.interpreter import Interpreter
from launcher.interpreter.replay import Replay, stale_containers
from launcher.language.compat import vocabulary
from launcher.language.description import LaunchDescription
from launcher.language.ros.composition import ComposableNode, ComposableNodeContainer
from launcher.model import events as model
from launcher.model.reload import Known, Reload
from launcher.model.spec_diff import comparable
from tests.unit.interpreter.interpreting import started


def container(*plugins: str) -> LaunchDescription:
    nodes = [ComposableNode(package="p", plugin=one, name=one.lower()) for one in plugins]
    action = ComposableNodeContainer(
        executable="/bin/cat", name="box", namespace="", composable_node_descriptions=nodes
    )
    return LaunchDescription([action])


def run_of(description: LaunchDescription) -> tuple[list[Known], list[model.LoadRequest]]:
    """The container of a run that has loaded all of its nodes."""
    interpreter = Interpreter(description)
    effects = interpreter.start()
    (process,) = started(effects)
    loads = []
    while found := [one for one in effects if isinstance(one, model.LoadComponent)]:
        loads.append(found[0].request)
        effects = interpreter.handle(model.ComponentLoaded(found[0].request_id))
    spec = process.spec
    known = Known(process.process_id, spec.name, comparable(spec), has_started=True, pid=7)
    interpreter.close()
    return [known], loads


def replayed(
    before: Sequence[str], after: Sequence[str], stale: Sequence[str] = ()
) -> tuple[Reload, set[str]]:
    with vocabulary():
        known, loads = run_of(container(*before))
        interpreter = Interpreter(container(*after))
        replay = Replay(
            interpreter,
            known,
            done=loads,
            said=(),
            adapt=lambda spec: spec,
            numbered=1,
            stale=stale,
        )
        reload = replay.run(100.0)
        interpreter.close()
        return reload, stale_containers(loads, replay, reload)


def plugins(effects: Sequence[model.Effect]) -> list[str]:
    return [one.request.plugin for one in effects if isinstance(one, model.LoadComponent)]


def test_nodes_that_are_loaded_are_not_loaded_again():
    reload, stale = replayed(["A", "B"], ["A", "B"])
    assert (reload.is_empty, plugins(reload.effects), stale) == (True, [], set())


def test_a_container_with_other_nodes_is_restarted_and_loads_them_when_it_runs():
    _, stale = replayed(["A", "B"], ["A", "C"])
    assert stale == {"/box"}
    reload, _ = replayed(["A", "B"], ["A", "C"], stale=["/box"])
    assert [one.changes for one in reload.kept] == [("components",)]
    assert plugins(reload.effects) == []
    ((_, after),) = reload.after
    assert plugins(after) == ["A"]  # C follows when A is loaded


def test_a_container_without_one_of_its_nodes_is_restarted():
    assert replayed(["A", "B"], ["A"])[1] == {"/box"}
