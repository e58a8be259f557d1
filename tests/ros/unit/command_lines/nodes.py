"""Command lines of `node`, `param`, `lifecycle` and `graph`, and what they mean."""

from __future__ import annotations

from tests.ros.unit.command_lines.options import BASE, Line

NODE = {**BASE, "node_name": "/n", "include_hidden_nodes": False, "timeout": None}
NODE["service_timeout"] = None
PARAMS = {**NODE, "param_prefixes": (), "param_type": False, "filter": None}
LIFECYCLE = {**BASE, "node_name": "/n", "timeout": None}
STATES = {**LIFECYCLE, "transitions": False}
GRAPH = {
    **BASE,
    "mode": "all",
    "include": None,
    "exclude": None,
    "debug_topics": False,
    "hidden": False,
    "dot": False,
    "mermaid": False,
    "svg": None,
    "html": None,
    "watch": False,
    "diff": None,
    "period": 0.5,
}

LINES: list[Line] = [
    ("node list -a -c", BASE, {"all": True, "count_nodes": True}),
    ("node list -ac", BASE, {"all": True, "count_nodes": True}),
    ("node info /n --include-hidden", BASE, {"node_name": "/n", "include_hidden": True}),
    ("node ps --all --answer-timeout 2", BASE, {"all": True, "answer_timeout": 2.0}),
    ("node ps", BASE, {"all": False, "answer_timeout": 1.0}),
    ("param list", PARAMS, {"node_name": None}),
    ("param list /n --param-type", PARAMS, {"param_type": True}),
    ("param list /n --param-prefixes a b", PARAMS, {"param_prefixes": ["a", "b"]}),
    ("param list --param-prefixes a b -- /n", PARAMS, {"param_prefixes": ["a", "b"]}),
    (
        "param list --param-prefixes a b --json /n",
        PARAMS,
        {"param_prefixes": ["a", "b"], "json": True},
    ),
    ("param list --param-prefixes=a /n", PARAMS, {"param_prefixes": ["a"]}),
    ("param list --service-timeout 2", PARAMS, {"node_name": None, "service_timeout": 2.0}),
    ("param get /n p --hide-type", NODE, {"parameter_names": ["p"], "hide_type": True}),
    ("param get /n p q", NODE, {"parameter_names": ["p", "q"], "hide_type": False}),
    ("param get p", NODE, {"node_name": None, "parameter_names": ["p"]}),
    ("param set /n p 1 q 2 --atomic", NODE, {"pairs": ["p", "1", "q", "2"], "atomic": True}),
    ("param delete /n p --timeout 2", NODE, {"parameter_name": "p", "timeout": 2.0}),
    ("param set /n p -5", NODE, {"pairs": ["p", "-5"], "atomic": False}),
    ("param set /n p -1.5", NODE, {"pairs": ["p", "-1.5"], "atomic": False}),
    ("param set /n p -- -x", NODE, {"pairs": ["p", "-x"], "atomic": False}),
    (
        "param describe /n p q --include-hidden-nodes",
        NODE,
        {"parameter_names": ["p", "q"], "include_hidden_nodes": True},
    ),
    ("param dump /n", NODE, {}),
    (
        "param load /n f.yaml --no-use-wildcard --timeout 3",
        NODE,
        {"parameter_file": "f.yaml", "no_use_wildcard": True, "timeout": 3.0},
    ),
    ("lifecycle nodes", BASE, {"include_hidden_nodes": False, "count_nodes": False}),
    ("lifecycle nodes -a -c", BASE, {"include_hidden_nodes": True, "count_nodes": True}),
    ("lifecycle nodes --all --spin-time 1", BASE, {"spin_time": 1.0}),
    ("lifecycle list /n", LIFECYCLE, {"all": False}),
    ("lifecycle list /n -a --include-hidden-nodes", LIFECYCLE, {"all": True}),
    ("lifecycle get", STATES, {"node_name": None}),
    ("lifecycle get /n --timeout 2 -t", STATES, {"timeout": 2.0, "transitions": True}),
    ("lifecycle get --include-hidden-nodes", STATES, {"node_name": None}),
    ("lifecycle set /n configure", LIFECYCLE, {"transition": "configure"}),
    ("lifecycle set /n 3 --timeout 9", LIFECYCLE, {"transition": "3", "timeout": 9.0}),
    ("graph", GRAPH, {}),
    ("graph --dot --mode nodes", GRAPH, {"dot": True, "mode": "nodes"}),
    (
        "graph --mermaid --include a --exclude=b",
        GRAPH,
        {"mermaid": True, "include": "a", "exclude": "b"},
    ),
    (
        "graph --svg f.svg --debug-topics --hidden",
        GRAPH,
        {"svg": "f.svg", "debug_topics": True, "hidden": True},
    ),
    ("graph --html=f.html", GRAPH, {"html": "f.html"}),
    ("graph --watch --period 2", GRAPH, {"watch": True, "period": 2.0}),
    ("graph --diff f.json --json -d 3", GRAPH, {"diff": "f.json", "json": True, "domain": "3"}),
]
