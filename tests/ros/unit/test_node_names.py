"""Names of the nodes of verbs, which others see in `service info -v` and `topic info -v`."""

from __future__ import annotations

import os

import pytest

from launcher.ros.discovery.observer import Observer
from launcher.ros.verb import GraphAccess
from launcher.ros.verbs import action, param, service, tf, topic


@pytest.mark.parametrize(
    ("command", "words", "name"),
    [
        (service.COMMAND, "call /switch std_srvs/srv/Empty", "service_call"),
        (action.COMMAND, "send_goal /a pkg/action/A", "action_send_goal"),
        (param.COMMAND, "get /talker speed", "param_get"),
        (topic.COMMAND, "hz /chatter", "topic_hz"),
        (tf.COMMAND, "tree", "tf_tree"),
    ],
)
def test_the_node_of_a_verb_is_called_after_it(command, words, name):
    access = GraphAccess.of(command.parse([*words.split(), "-d", "7"]))

    observer = Observer(access.domain_id, purpose=access.verb)

    assert observer.name.startswith(f"_launcher_{name}_{os.getpid()}_")
    assert observer.name.replace("_", "").isalnum()
