"""Record on a disk of 200 KB until it is full: for `unshare`, with a mounted folder as argument.

The second argument is the JSON of the storage. Prints what the bag has as JSON.
"""

from __future__ import annotations

import itertools
import json
import os
import sys

from launcher.bag import check, metadata
from launcher.bag.reader import Bag
from launcher.bag.ros.sinks import FileSink
from launcher.bag.writer import BagWriter, Storage
from tests.support.bags import message, string_topic, text_of


def main(disk: str, storage: str) -> None:
    folder = os.path.join(disk, "bag")
    writer = BagWriter(folder, Storage(**json.loads(storage)))
    writer.add_topic(string_topic("/a"))
    written = []
    try:
        for number in itertools.count():
            writer.write(message("/a", number, f"{number} {os.urandom(400).hex()}"))
            written.append(number)
            if number % 5 == 4:
                writer.flush()
    except OSError:
        pass
    sink = FileSink(writer, 1)
    sink.error = OSError("full")
    sink.finish()
    found = [int(text_of(one.data).split()[0]) for one in Bag(folder).messages()]
    described = metadata.read(folder)
    report = {
        "whole": check.check(folder).is_whole and sink.is_whole,
        "written": len(written),
        "first ones": found == written[: len(found)],
        "found": len(found),
        "described": described is not None and described.extent.total,
        "files": sorted(os.listdir(folder)),
        "listed": [] if described is None else [file.path for file in described.files],
    }
    print(json.dumps(report))


if __name__ == "__main__":
    main(*sys.argv[1:])
