"""Messages for mistakes in interface files, from the exceptions of rosidl's parser."""

from __future__ import annotations

import re

from launcher.base.text import did_you_mean
from launcher.workspace.building.sources.source_text import PackageText, SourceError

_INSTEAD = {
    "int": "int32", "unsigned": "uint32", "uint": "uint32", "long": "int64", "short": "int16",
    "float": "float32 or float64", "double": "float64", "str": "string", "text": "string",
    "boolean": "bool", "Bool": "bool", "bytes": "uint8[]", "list": "an array as int32[]",
    "header": "std_msgs/Header", "time": "builtin_interfaces/Time",
    "duration": "builtin_interfaces/Duration",
}  # fmt: skip
_FIELD_NAMES = "lower case letters, digits and single underscores, beginning with a letter"
_CONSTANT_NAMES = "upper case letters, digits and single underscores, beginning with a letter"


def name_error(source: PackageText, name: str, suffix: str) -> SourceError | None:
    """The error for a file whose name is not valid for an interface; rosidl takes any for IDL."""
    if re.fullmatch(r"[A-Z][A-Za-z0-9]*", name):
        return None
    camel = "".join(part[:1].upper() + part[1:] for part in re.split(r"[^A-Za-z0-9]+", name))
    camel = camel.lstrip("0123456789")
    hint = f"rename it to {camel[:1].upper() + camel[1:]}{suffix}" if camel else None
    report = source.warning if suffix == ".idl" and name.isidentifier() else source.error
    return report(
        f"'{name}' is not a valid name of an interface: letters and digits, beginning with an "
        "upper case letter",
        hint=hint,
    )


def explained(source: PackageText, number: int, line: str, problem: Exception) -> SourceError:
    """The error for a line that rosidl's parser refuses with an exception."""
    code = line.partition("#")[0].rstrip()
    if code[:1].isspace():
        words = " ".join(code.split())
        return source.error("the line is indented", number, hint=f"write '{words}'")
    type_, _, rest = code.replace("\t", " ").partition(" ")
    message, at, hint = _explanation(type_, rest.strip(), problem)
    return source.error(message, number, at=at, hint=hint)


def _explanation(type_: str, rest: str, problem: Exception) -> tuple[str, str, str | None]:
    """Message, the text that the caret points to, and hint."""
    kind, text = type(problem).__name__, str(problem)
    parts = re.match(r"(\S*?)\s*(=|\s|$)\s*(.*)", rest, re.DOTALL)
    assert parts is not None  # it matches every text
    name, sign, value = parts.groups()
    if type_.startswith("---"):
        return "a .msg file has one part, without '---'", type_, "services are .srv files"
    if kind == "InvalidFieldDefinition":
        is_type = re.fullmatch(r"[\w/\[\]<=]+", type_)
        is_comment = type_.startswith(("//", "/*", "--"))
        hint = "a comment begins with '#'" if is_comment else f"write for example '{type_} value'"
        return "a field has a type and a name", type_, hint if is_type or is_comment else None
    if kind == "InvalidValue":
        return _about_value(text), value or rest, None
    if kind == "NotImplementedError":
        return f"a field of type {type_} has no default value", value, "remove the value"
    if kind == "NameError":
        return _about_name(type_, name, sign, value)
    if kind == "ValueError" and value:
        return f"the value cannot be understood: {text.splitlines()[0]}", value, None
    return _about_type(type_, text, kind)


def _about_value(text: str) -> str:
    found = re.match(r"value '(.*?)' can not be converted to type '([^']*)': (.*)", text, re.DOTALL)
    if found is None:
        return text
    value, type_, reason = found.groups()
    element = re.match(r"element (\d+) with (value .*)", reason, re.DOTALL)
    if element is not None:
        return f"element {int(element[1]) + 1}: {_about_value(element[2])}"
    return f"'{value}' is not a value of {type_}: {reason.removeprefix('array ')}"


def _about_name(type_: str, name: str, sign: str, value: str) -> tuple[str, str, str | None]:
    if sign == "=":
        upper = re.sub(r"_+", "_", re.sub(r"\W", "_", _snake(name).upper())).strip("_")
        default = f", or '{type_} {_snake(name)} {value}' for a field with a default value"
        return (
            f"'{name}' is not a valid name of a constant: {_CONSTANT_NAMES}",
            name,
            f"write '{type_} {upper}={value}'{default if name.islower() else ''}",
        )
    if name.endswith(";"):
        return "a line does not end with ';'", ";", f"write '{type_} {name.rstrip(';')}'"
    if "," in name:
        fields = [word for word in re.split(r"[,\s]+", f"{name} {value}") if word]
        lines = " and ".join(f"'{type_} {field}'" for field in fields)
        return "each field needs a separate line", name, f"write {lines}"
    if "[" in name:
        bare, _, size = name.partition("[")
        return "the size of an array belongs to its type", name, f"write '{type_}[{size} {bare}'"
    if value and name.isupper():
        return (
            f"'{name}' is not a valid field name: {_FIELD_NAMES}",
            name,
            f"write '{type_} {name}={value}' for a constant",
        )
    valid = _snake(name)
    hint = f"write '{valid}'" if re.fullmatch(r"[a-z][a-z0-9_]*", valid) else None
    return f"'{name}' is not a valid field name: {_FIELD_NAMES}", name, hint


def _about_type(type_: str, text: str, kind: str) -> tuple[str, str, str | None]:
    from rosidl_adapter.parser import PRIMITIVE_TYPES

    base, bracket, size = type_.partition("[")
    if re.match(r"w?string<=", base) and "/" not in base:
        wanted = base.partition("<=")[0]
        return "the bound of a string is a number above 0", type_, f"write for example {wanted}<=10"
    if re.match(r"w?string[<(]", base):
        return f"unknown type '{type_}'", type_, "write string<=10 for at most 10 characters"
    parts = base.split("/")
    if len(parts) == 3 and parts[1] in ("msg", "srv", "action"):
        return f"'{base}' is not a type", type_, f"write {parts[0]}/{parts[2]}"
    if ("[" in type_) != type_.endswith("]") or type_.count("[") > 1:
        return f"the brackets of '{type_}' are wrong", type_, "write int32[3] or int32[]"
    if bracket and kind == "TypeError":
        return (
            f"'{size[:-1]}' is not the size of an array: a number above 0",
            type_,
            f"write {base}[] for any length, {base}[3] for exactly 3, {base}[<=3] for at most 3",
        )
    if base in ("time", "duration"):
        return f"ROS 2 has no type '{base}'", type_, f"write {_INSTEAD[base]}"
    instead = _INSTEAD.get(base)
    hint = f"write {instead}" if instead else did_you_mean(base, PRIMITIVE_TYPES)
    if "/" in base and len(parts) == 2 and not re.fullmatch(r"[A-Z]\w*", parts[1]):
        hint = f"write {parts[0]}/{parts[1][:1].upper()}{parts[1][1:]}"
    return f"unknown type '{base}'", type_, hint


def _snake(name: str) -> str:
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", re.sub(r"\W", "_", name))
    return re.sub(r"_+", "_", words.lower()).strip("_")
