"""`bag convert`: cuts, merges, splits and renames bags, and writes tables."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from launcher.bag.converting.time_texts import Moment, duration_ns, moment
from launcher.bag.verbs.files import COMPRESSION, INPUT, SPLIT, inputs, storage_of
from launcher.bag.verbs.info import warn_of
from launcher.bag.verbs.topics import SELECT, remapping, selected, warn_of_excluded
from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, LauncherError, UsageError
from launcher.base.option import DEBUG, option
from launcher.ros.verb import warn

if TYPE_CHECKING:
    from launcher.bag.bag_model import Topic
    from launcher.bag.converting.convert import Output
    from launcher.bag.converting.output_options import InputPart

_KINDS = ("csv", "jsonl", "mcap")
_NO_LANGUAGE = ("", "unknown")  # of definitions, as rosbag2 writes what it does not find
_OF_BAGS = ("max_bag_size", "max_bag_duration", "compression_mode", "compression_format")

_BESIDE_YAML = {"--output", "--input", "--input-options", "--debug", "--workspace"}


def _offset(word: str) -> Moment:
    return Moment(duration_ns(word), from_start=True)


def _convert(options: Parsed) -> int:
    from launcher.bag.converting.convert import STDOUT, convert
    from launcher.bag.reader import Bag
    from launcher.posix.allocator import keep_freed_memory

    keep_freed_memory()
    parts = _parts(options)
    if not options.output:
        raise UsageError("-o OUT is missing", hint="a new folder, or a file: .mcap, .csv, .jsonl")
    outputs = list(_outputs(options))
    bags = [Bag(one.path) for one in parts]
    for bag in bags:
        warn_of(bag)
    warn_of_excluded(options, [topic for bag in bags for topic in bag.topics])
    for output in outputs:
        print(
            convert(bags, output, _complete, warn, [one.span for one in parts]),
            file=sys.stderr if output.path == STDOUT else sys.stdout,
            flush=True,
        )
    return ExitCode.OK


def _parts(options: Parsed) -> list[InputPart]:
    from launcher.bag.bag_model import Span
    from launcher.bag.converting import output_options

    paths = [*(options.bags or ()), *inputs(options)]
    if options.input_options is None:
        if not paths:
            raise UsageError("no bag to read was named", hint=f"usage: {options.command.usage}")
        return [output_options.InputPart(path, Span()) for path in paths]
    if paths:
        raise UsageError(f"bags are in {options.input_options}, or named; not both")
    return output_options.read_inputs(options.input_options)


def _outputs(options: Parsed) -> Iterator[Output]:
    from launcher.bag.converting import output_options

    if options.output.endswith((".yaml", ".yml")):
        given = {one.flags[-1] for one, *_ in options.given if one is not None}
        if others := sorted(
            given - {"--output", "--input", "--input-options", "--debug", "--workspace"}
        ):
            raise UsageError(f"{others[0]} goes into {options.output}, which has all options")
        yield from output_options.read(options.output)
    else:
        yield _output(options)


def _output(options: Parsed) -> Output:
    from launcher.bag.converting import convert

    kind = options.to or convert.kind_of(options.output)
    if options.output == convert.STDOUT and kind == "mcap":
        raise UsageError("a bag cannot be written to stdout", hint="--to csv or --to jsonl")
    given = [one for one, *_ in options.given if one is not None]
    for one in given:
        is_whole_bag = kind == "mcap" and not convert.is_single_file(options.output)
        if one.name in _OF_BAGS and not is_whole_bag:
            raise UsageError(f"{one.flags[-1]} is for bags that are folders", hint="-o DIR")
        if one.name == "field" and kind == "mcap":
            raise UsageError("--field is for tables", hint="--to csv or --to jsonl")
    return convert.Output(
        path=options.output,
        kind=kind,
        selection=selected(options),
        start=options.start or options.start_offset,
        end=options.end,
        length_ns=options.duration,
        remap=dict(options.remap or ()),
        storage=storage_of(options),
        fields=options.field or (),
    )


def _complete(topic: Topic) -> Topic:
    """With the definition and the hash of the installed type, where the bag has none.

    So has one in a language that is not .msg, if the installed type is the same.
    """
    from launcher.bag.bag_model import CDR, ROS2_MSG, Definition

    known = topic.definition
    is_usual = known is not None and known.encoding == ROS2_MSG
    if topic.serialization != CDR or (is_usual and topic.type_hash):
        return topic
    from launcher.ros.messages.message_schema import rihs_hash, schema_text

    try:
        text, installed_hash = schema_text(topic.type), rihs_hash(topic.type)
    except LauncherError as error:
        if known is None:
            warn(f"{topic.name}: the bag has no definition of its type, and {error.message}")
        return topic
    type_hash = topic.type_hash or installed_hash
    if is_usual:
        return replace(topic, type_hash=type_hash)
    is_known = known is not None and known.encoding not in _NO_LANGUAGE
    if (topic.type_hash if is_known else type_hash) == installed_hash:
        return replace(topic, definition=Definition(text=text), type_hash=type_hash)
    return topic


_TIMES = (
    option(
        "--start TIME",
        "from here on: seconds from the start of the bag, or since the epoch, or an ISO date",
        moment,
    ),
    option("--end TIME", "up to here, in the same ways", moment),
    option("--start-offset S", "from S seconds after the start of the bag on", _offset),
    option("--duration S", "S seconds of it", duration_ns),
)

COMMAND = Command(
    "bag convert",
    "cut, merge, split, rename and compress bags; CSV and JSON lines",
    about="Write a new bag, or a table, with the messages of bags. Messages are copied as they "
    "are; topics of the same name and type become one.",
    arguments=(option("[BAG ...]", "folders, or .mcap and .db3 files", name="bags"),),
    options=(
        option(
            "-o, --output OUT",
            "folder to make, or file: .mcap, .csv, .jsonl, - with --to; or the YAML file of "
            "options of ros2 bag convert",
        ),
        INPUT,
        option("--input-options FILE", "YAML: input_bags, as in ros2 bag convert"),
        option("--to FORMAT", "in place of what OUT ends with", choices=_KINDS),
        *SELECT,
        *_TIMES,
        option("--remap OLD:=NEW", "another name for a topic", remapping, repeat="all"),
        option("--field PATH", "of tables, only this field: a.b[0]", repeat="all"),
        *SPLIT,
        *COMPRESSION,
        DEBUG,
    ),
    exclusive=(("start", "start_offset"), ("end", "duration")),
    abbreviations=True,
    run=_convert,
)
