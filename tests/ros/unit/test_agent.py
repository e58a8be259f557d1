"""What the agent makes of requests before it sends them."""

from __future__ import annotations

import pytest

from launcher.ros.helpers.agent import parameter_messages, reason


def test_values_of_every_type_fit_into_the_message():
    values = {
        "b": True,
        "i": -(2**63),
        "f": float("inf"),
        "s": "ü",
        "y": [b"a", b"\xff"],
        "bs": [True],
        "is": [1, 2],
        "fs": [0.5],
        "ss": ["a"],
    }
    messages = parameter_messages(list(values.items()))
    assert [message.value.type for message in messages] == [1, 2, 3, 4, 5, 6, 7, 8, 9]
    assert messages[4].value.byte_array_value == [b"a", b"\xff"]


@pytest.mark.parametrize(
    ("value", "why"),
    [(2**63, "int too big to convert"), ("\udc80", "surrogates not allowed")],
)
def test_a_value_that_cannot_be_sent_is_refused_by_name(value, why):
    with pytest.raises(ValueError, match=f"parameter 'speed' cannot be sent: .*{why}"):
        parameter_messages([("speed", value)])


def test_the_reason_names_what_caused_the_error():
    try:
        try:
            raise ImportError("libx.so: cannot open\nshared object file")
        except ImportError:
            raise RuntimeError("no type support for 'x'")  # noqa: B904  # as rosidl does
    except RuntimeError as error:
        found = reason(error)
    assert found == "no type support for 'x': libx.so: cannot open shared object file"
    assert reason(ValueError("plain")) == "plain"
