"""The modules of the page as one script, and its style sheets as one: each file is a round trip.

There is no build step: the files are read as they are, and the server joins them. Every module
becomes a function that is called when it is first imported, so that panels that nobody opens cost
nothing but their text. What has been joined is `/page/main.js`; who imports another module by its
address gets the same one, from there (`facade`).

It reads the forms of `import` and `export` that the page uses, not all of JavaScript
(tests/web/unit/test_page_bundle.py).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

ENTRY = "main.js"
_PLACE = "page/"
_IMPORT = re.compile(r'^import (\{[^}]*\}|\* as \w+) from "([\w./-]+)";$', re.MULTILINE)
_DYNAMIC = re.compile(r"\bimport\((?=[\"`]page/)")
_EXPORT = re.compile(r"^export (?=(?:const|class|function|async function) (\w+))", re.MULTILINE)
_DEFAULT = re.compile(r"^export default (?=\{)", re.MULTILINE)
_OTHER = re.compile(r"^(?:import|export)\b.*", re.MULTILINE)


class Module(NamedTuple):
    """A module as the body of a function. `imports`: names of those that it needs at once."""

    body: str
    imports: tuple[str, ...]
    exports: tuple[str, ...]


def module_of(text: str) -> Module:
    """Read a module; ValueError if it imports or exports in a way that is not known here."""
    imports = tuple(name for _, name in _IMPORT.findall(text))
    exports = tuple(_EXPORT.findall(text))
    body = _IMPORT.sub(lambda match: f"const {_names(match[1])} = $get({match[2]!r});", text)
    body = _EXPORT.sub("", body)
    if "import(" in body:
        body = _DYNAMIC.sub("$load(", body)
    body, defaults = _DEFAULT.subn("const $default = ", body)
    if other := _OTHER.search(body):
        raise ValueError(f"an import or export of another form: {other[0]}")
    return Module(body, imports, exports + ("default",) * defaults)


def _names(clause: str) -> str:
    """What is written before `from`, as a pattern of `const`."""
    return clause.removeprefix("* as ") if clause[0] == "*" else clause.replace(" as ", ": ")


def bundle(modules: Mapping[str, Module]) -> str:
    """A script of these modules, of which ENTRY runs; by their names below `/page/`."""
    outside = sorted(
        {name for module in modules.values() for name in module.imports}
        - {_PLACE + name for name in modules}
    )
    parts = [f'import * as $outside{number} from "{name}";' for number, name in enumerate(outside)]
    parts.append("const $made = {")
    parts += [f'  "{name}": $outside{number},' for number, name in enumerate(outside)]
    parts.append("};\nconst $makers = {")
    parts += [_maker(name, module) for name, module in modules.items() if name != ENTRY]
    parts += [_LOADER, f"// {_PLACE}{ENTRY}", modules[ENTRY].body]
    return "\n".join(parts)


_LOADER = """\
};
function $get(name) {
  return ($made[name] ??= $makers[name]());
}
const $load = async (name) => $get(name);
export { $get };"""


def _maker(name: str, module: Module) -> str:
    pairs = ", ".join("default: $default" if one == "default" else one for one in module.exports)
    tag = '[Symbol.toStringTag]: "Module"'  # by which Vue sees that the component is the default
    return f'"{_PLACE}{name}"() {{\n{module.body}\nreturn {{ {tag}, {pairs} }};\n}},'


def facade(name: str, module: Module) -> str:
    """A module with the exports of one that is in the bundle."""
    named = ", ".join(one for one in module.exports if one != "default")
    lines = [
        f'import {{ $get }} from "{_PLACE}{ENTRY}";',
        f'const $module = $get("{_PLACE}{name}");',
        f"export const {{ {named} }} = $module;",
    ]
    if "default" in module.exports:
        lines.append("export default $module.default;")
    return "\n".join(lines)
