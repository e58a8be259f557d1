"""LoadNode and ListNodes, carried by the lists of texts of another service, over DDS as well."""

import json
from typing import Any

from rcl_interfaces.srv import ListParameters

LoadNode = ListNodes = ListParameters
Request, Response = ListParameters.Request, ListParameters.Response

REQUEST = ("package_name", "plugin_name", "node_name", "node_namespace", "remap_rules")
RESPONSE = ("success", "error_message", "full_node_name", "unique_id")


def _init(self: Any, _real: Any = Request.__init__, **fields: Any) -> None:
    _real(self)
    self.prefixes = [json.dumps({name: fields.get(name) for name in REQUEST})]


def _put(self: Any, **fields: Any) -> Any:
    """Fill in a response of LoadNode."""
    self.result.names = [json.dumps(fields)]
    return self


def _put_nodes(self: Any, nodes: dict[int, str]) -> Any:
    """Fill in a response of ListNodes."""
    self.result.prefixes = [str(number) for number in nodes]
    self.result.names = list(nodes.values())
    return self


def _field(name: str, text: Any) -> property:
    return property(lambda self: json.loads(text(self)).get(name))


Request.__init__ = _init
for _name in REQUEST:
    setattr(Request, _name, _field(_name, lambda self: self.prefixes[0]))
for _name in RESPONSE:
    setattr(Response, _name, _field(_name, lambda self: self.result.names[0]))
Response.put, Response.put_nodes = _put, _put_nodes
Response.full_node_names = property(lambda self: list(self.result.names))
Response.unique_ids = property(lambda self: [int(text) for text in self.result.prefixes])
