"""The forms of what `--json` prints: each verb with its keys.

`tools.json_reference` writes docs/reference/json.md from this table, and tests compare real answers
with it. The text of a form:

    name          a text, a number, true, false or null
    name?         the same, absent where there is nothing to say
    name[]        a list of such values
    name[a, b]    a list of objects with these keys
    name{a, b}    an object with these keys
    name{}        an object whose keys are names that users give
    name*         any value, of users or of another standard

An object or a list may also be null.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from launcher.base.model.event_entries import annotations_of
from launcher.base.model.run_event import TYPES, RunEvent

_EXIT = "last_exit{returncode, text, asked, wall_s}"
_PROCESS = (
    "name, label, state, pid, restarts, uptime_s, cpu_percent, uss_bytes, rss_bytes, threads, fds, "
    "node_names[], namespace, muted, hidden_by, muted_by_name, hidden_lines, level, grep, paused, "
    f"debugger, start, not_responding_s, {_EXIT}, host?, unit?, stop_after_s?, unreachable_s?, "
    "host_silent_s?, ready?, ready_s?, waiting_for?, lacks?, faults?[], injected?[]"
)
_INFO = (
    "cmd[], cwd, shell, start_text, package, executable, env{}, env_set{}, env_unset[], "
    "restart_policy, stop_policy, watched_files, log_file"
)
_FAULT = (
    "fault, expectation, kind, place, state, expected, seen, value, unit, first_s, confirmed_s, "
    "last_s, healed_s, count, lines[], message*, processes[], nodes[], topics[], cause, rule, "
    "follows, incident, acknowledged{wall_s, reason}, muted{reason, until_s}"
)
_VERSION = "files_hash, git"
_STAMP = "time, phase, cause, since_cause"
_QOS = "reliability, durability, liveliness, deadline_ns, lease_ns"
_TYPED = "name, types[]"
_TOPIC_OF_BAG = (
    "name, type, messages, serialization_format, type_hash, qos*, size_bytes?, "
    "rate?{mean_hz, min_hz, max_hz, longest_gap_s, longest_gap_start_ns, parts_hz[]}"
)
_TRAITS = "name, messages, type, type_hash, start_ns, rate_hz, gap_s, latency_s, latency_p99_s"
_SPREAD = "min_s, max_s, std_dev_s, window"
_DELAYS = "mean_delay_s, max_delay_s"
_FINDING = "level, text, advice"
_RELOAD = "processes[name, change, details[], done, text]"
_DROPPED = "dropped, processes?{}, wall_s?"
_EVENT = "wall_s, monotonic_s, event, process?, host?"


class Form(NamedTuple):
    """What verbs print; `kinds` are the texts of its forms, more than one if lines differ.

    With `lines`, each line is such an object. `page` describes the keys in its place.
    """

    verbs: tuple[str, ...]
    kinds: tuple[str, ...]
    lines: bool = False
    page: str = ""
    note: str = ""


def _form(verbs: str, *kinds: str, **more: Any) -> Form:
    return Form(tuple(verbs.split(", ")), kinds, **more)


def _entry(event: type[RunEvent]) -> str:
    return ", ".join([_EVENT, *(f"{name}?*" for name in annotations_of(event))])


# Each title of the page with its forms.
FORMS: Mapping[str, tuple[Form, ...]] = {
    "Launch files and runs": (
        _form(
            "plan",
            "arguments[name, description, has_default, default, choices[]], arguments_error?, "
            "declared{}, processes[package, executable, node_name, namespace, remappings*, cmd[], "
            "parameters*, env_set{}, env_unset[], cwd, shell, output*, emulate_tty, respawn, "
            "respawn_delay, respawn_max_retries, sigterm_timeout, sigkill_timeout, label, "
            f"{_STAMP}, host?, skipped?, on_host?{{cmd[], setup[], cwd, env_set{{}}, env_names[], "
            "env_unset[], files[name, bytes]}, ready_when?[kind, subject, node], "
            "after?{names[], processes[], timeout, on_timeout}, restart_with?[]], "
            "loads[container, package, plugin, name, namespace, remappings*, parameters*, "
            f"extra_arguments*, {_STAMP}], lifecycle[node, transition, {_STAMP}], "
            f"logs[message, {_STAMP}], shutdowns[reason, {_STAMP}], "
            "error{type, message, stage, phase}, discovery?{}",
            page="[plan-json.md](plan-json.md)",
        ),
        _form("plan --diff, reload", _RELOAD),
        _form(
            "analyze",
            "log_dir, ready_s, is_ready, processes[name, queued_s, released_s, started_s, "
            "ready_s, ended_s, own_s, waited_for[], why, has_ready_when], critical_chain[]",
        ),
        _form(
            "runs",
            "runs[id, pid, socket, problem, target, arguments[], started_wall_s, log_dir, "
            "domain_id, processes[]]",
        ),
        _form("wait", "holds, waited_s, conditions[name, wanted, holds, text]"),
        _form(
            "ps",
            f"processes[{_PROCESS}], sampled_every_s, unknown_response?[], "
            "unanswered?[name, asked, reason]",
        ),
        _form("top", f"processes[{_PROCESS}], sampled_every_s", lines=True, page="as `ps`"),
        _form(
            "info",
            f"processes[{_PROCESS}, {_INFO}]",
            page=f"as `ps`; each process also `{_INFO}`",
        ),
        _form(
            "stop, start, restart, pause, resume, kill, send",
            "processes[name, done, text]",
        ),
        _form("mute, unmute, solo, level, grep, show", "processes[name, text, hidden_lines]"),
        _form("format", "format"),
        _form("logs", "process, stream, wall_s, text", _DROPPED, lines=True),
        _form(
            "events",
            *map(_entry, TYPES.values()),
            _DROPPED,
            lines=True,
            page=f"`{_EVENT}` and those of the [event](events.md), or `{_DROPPED}`",
        ),
        _form(
            "faults",
            f"faults[{_FAULT}], mutes[fault, reason, until_s], "
            "left_to_smoke[expectation, why], watching",
            f"faults[{_FAULT}]",
            note="[faults](faults.md); with `--acknowledge`, `--mute`, `--unmute` only the fault",
        ),
        _form(
            "faults --follow",
            f"{_FAULT}, change",
            _DROPPED,
            lines=True,
            page="those of a fault, and `change`",
        ),
        _form(
            "faults --all-runs",
            "targets[target, runs, since_s, faults[fault, kind, since_s, last_s, times, runs, "
            f"runs_since, first_version{{{_VERSION}}}, last_version{{{_VERSION}}}, versions, "
            "seen, cause, muted{reason, until_s}]]",
        ),
        _form("watch", "on, launch_files[], processes[name, watched, files[]]"),
        _form(
            "stack",
            "processes[name, stacks[pid, command, problem, hint, threads[tid, name, state, "
            "frames[function, file, line, locals{}]]]]",
        ),
        _form("debug", "name, pid, address, waits, configuration*"),
        _form("loglevel", "levels[process, node, error, logger?, level?, source?]"),
        _form("inject", "injections[name, injection, began_wall_s, for_s, left_s, problem]"),
        _form("snapshot", "path"),
        _form(
            "incident",
            "log_dir, incidents[id, is_snapshot, path, opened_s, closed_s, title, faults[]]",
            "incident*",
            page="`log_dir, incidents[id, is_snapshot, path, opened_s, closed_s, title, "
            "faults[]]`; with an ID `incident`: the document without secrets",
        ),
        _form("detach", "left[name, host], stopped[], withdrawn[]"),
        _form("quit", "running"),
    ),
    "The ROS graph": (
        _form(
            "graph",
            f"nodes[], topics[], ghosts[], endpoints[topic, node, direction, type, {_QOS}, gid], "
            "mismatches[source, target, topic, fault]",
        ),
        _form("graph --diff", "differences[change, text]"),
        _form("graph --watch", "wall_s, change, text", lines=True),
        _form("topic list", "topics[name, types[], publisher_count, subscription_count]"),
        _form("topic type, service type, action type", _TYPED),
        _form(
            "topic find, service list, service find, action list, action find",
            f"topics[{_TYPED}]",
            f"services[{_TYPED}]",
            f"actions[{_TYPED}]",
            page="`topics`, `services` or `actions`: `[name, types[]]`",
        ),
        _form(
            "topic info",
            f"{_TYPED}, endpoints[node, direction, type, {_QOS}, gid], mismatches[subscription, "
            "publishers[], policies[policy, offered, requested, advice]], explanation",
        ),
        _form(
            "tf tree",
            "frames[frame, parent, static, broadcasters[], transforms, rate_hz, buffer_s, "
            "newest_ns, oldest_ns], roots[], problems[kind, frame, text]",
        ),
        _form(
            "tf echo",
            "time_ns, frame, child, translation[], rotation[], rpy[]",
            "time_ns, failure",
            lines=True,
        ),
        _form(
            "tf monitor",
            f"wall_s, chain[], net_delay{{{_DELAYS}}}, frames[frame, broadcaster, {_DELAYS}], "
            f"broadcasters[node, rate_hz, {_DELAYS}]",
            lines=True,
        ),
        _form("topic echo, service echo", "topic, message*, info?{}", lines=True),
        _form("topic pub", "topic, number, message*", lines=True),
        _form(
            "topic hz",
            f"topic, event, mean_hz, {_SPREAD}",
            "topic, event, messages, mean_hz",
            lines=True,
            note="`event`: `rate`, or with `--for` at the end `total`",
        ),
        _form(
            "topic bw",
            "topic, event, bytes_per_s, messages, min_bytes, max_bytes",
            "topic, event, messages, bytes, bytes_per_s",
            lines=True,
            note="`event`: `rate`, or with `--for` at the end `total`",
        ),
        _form("topic delay", f"topic, event, mean_s, {_SPREAD}, fresh", lines=True),
        _form("node list", "nodes[name, count]"),
        _form(
            "node info",
            f"name, subscribers[{_TYPED}], publishers[{_TYPED}], service_servers[{_TYPED}], "
            f"service_clients[{_TYPED}], action_servers[{_TYPED}], action_clients[{_TYPED}]",
            page="`name`; `subscribers`, `publishers`, `service_servers`, `service_clients`, "
            "`action_servers`, `action_clients`: `[name, types[]]`",
        ),
        _form(
            "node ps",
            "nodes[name, program, run_id, liveness, pid, cpu_percent, uss_bytes, uptime_s]",
        ),
        _form("param list", "nodes[name, parameters[name, type?]]"),
        _form(
            "param get",
            "node, name, type, value*",
            "node, parameters[name, type, value*]",
            "parameters[node, name, type, value*]",
        ),
        _form("param dump", "node, parameters[name, type, value*]"),
        _form("param set, param load, param delete", "node, parameters[name, done, reason]"),
        _form(
            "param describe",
            "node, parameters[name, type, description, additional_constraints, read_only, "
            "dynamic_typing, floating_point_range*, integer_range*]",
        ),
        _form(
            "service info",
            f"{_TYPED}, clients[], servers[], endpoints[node, role, type_hash, request_reader?*, "
            "request_writer?*, response_reader?*, response_writer?*]",
        ),
        _form("service call", "response*", lines=True),
        _form("action info", "name, clients[node, types[]], servers[node, types[]]"),
        _form(
            "action send_goal",
            "event, goal_id",
            "event, feedback*",
            "event, status, result*",
            lines=True,
            note="`event`: `accepted`, `rejected` or `canceled`; `feedback`; `ended`",
        ),
        _form("action echo", "interface, topic, message*", lines=True),
        _form("lifecycle nodes", "nodes[name]"),
        _form("lifecycle get", "nodes[name, state{id, label}, transitions?[id, label]]"),
        _form("lifecycle list", "node, transitions[id, label, start, goal]"),
        _form("lifecycle set", "node, transition{id, label}, done"),
        _form("interface list", "interfaces[]"),
        _form("interface package", "package, interfaces[]"),
        _form("interface packages", "packages[]"),
        _form("interface show", "name, definition[]"),
        _form("interface proto", "name, message*"),
        _form(
            "foxglove",
            "event, url, domain_id",
            "event, client, address",
            lines=True,
            note="`event`: `listening`; `connected` or `disconnected`",
        ),
    ),
    "Bags": (
        _form(
            "bag info",
            "bags[path, files[], size_bytes, storage, ros_distro, start_ns, end_ns, duration_ns, "
            f"messages, notes[], custom_data{{}}, topics[{_TOPIC_OF_BAG}], "
            f"services[{_TOPIC_OF_BAG}, topic, requests?, responses?], "
            f"actions[name, type, topics[{_TOPIC_OF_BAG}]]]",
            page=f"bags[path, files[], size_bytes, storage, ros_distro, start_ns, end_ns, "
            f"duration_ns, messages, notes[], custom_data{{}}, topics[{_TOPIC_OF_BAG}], "
            "services[the same, topic, requests?, responses?], "
            "actions[name, type, topics[the same]]]",
        ),
        _form(
            "bag check",
            "bags[path, whole, problems[], files[name, messages, notes[], conflicts[], "
            "faults[offset, text, lost]]]",
        ),
        _form(
            "bag compare",
            f"a, b, alike, shift_ns, topics[name, a{{{_TRAITS}}}, b{{{_TRAITS}}}, compared, "
            "differences[kind, a*, b*, path, index, note]]",
            page=f"a, b, alike, shift_ns, topics[name, a{{{_TRAITS}}}, b{{the same}}, compared, "
            "differences[kind, a*, b*, path, index, note]]",
        ),
    ),
    "Machines and workspaces": (
        _form("doctor", f"well, fixed[], findings[check, {_FINDING}, fixable]"),
        _form("doctor --report", "sections[title, entries[name, value]]"),
        _form("doctor --uninstall-list", "size_bytes, remains[what, path, size_bytes, command]"),
        _form(
            "hosts check",
            "well, discovery, hosts[name, address, reached, login_s, user, error, engine?, "
            "systemd?, python?, launcher?, missing?{packages[], executables*, interfaces[]}, "
            "clock_offset_s?, clock_uncertainty_s?, ros_distro?, middleware?, domain_id?, "
            "folders?[path, existing, error?, total_bytes?, free_bytes?, inodes?, free_inodes?, "
            "writable?], max_sessions?, addresses?[]], network{unicast*, multicast*}, "
            f"findings[check, hosts[], {_FINDING}]",
        ),
        _form("env", "env{}"),
    ),
}


def all_forms() -> Iterator[Form]:
    for forms in FORMS.values():
        yield from forms


def form_of(verb: str) -> Form:
    """The form of a verb; of one with an option in its name, of that form of it."""
    return next(form for form in all_forms() if verb in form.verbs)
