"""Transforms of a bag, for `tf`: neither tf2 nor the type of its messages is needed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from launcher.bag.bag_model import CDR, BagError
from launcher.bag.reader import Bag
from launcher.ros.tf import tf_message
from launcher.ros.tf.frame_tree import TfSample


def samples(path: str, topics: Sequence[str]) -> Iterator[TfSample]:
    """The messages of two topics, of moving and of static transforms, in the order of their times.

    BagError if the bag has neither of them.
    """
    bag = Bag(path)
    known = {topic.name: topic for topic in bag.topics if topic.type == tf_message.TYPE}
    chosen = [known[name] for name in topics if name in known]
    if not chosen:
        named = ", ".join(sorted(known))
        raise BagError(
            f"{path}: no transforms on {' and '.join(topics)}",
            hint=f"--tf-topic and --tf-static-topic: it has {named}" if known else None,
        )
    for topic in chosen:
        if topic.serialization != CDR:
            raise BagError(f"{topic.name}: messages in '{topic.serialization}' cannot be decoded")
    for message in bag.messages([topic.name for topic in chosen]):
        try:
            transforms = tf_message.read(message.data)
        except ValueError as error:
            raise BagError(f"{path}: {message.topic}: {error}") from None
        yield TfSample(message.log_ns, message.topic == topics[1], "", transforms)
