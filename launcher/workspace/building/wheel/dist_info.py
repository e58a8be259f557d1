"""The files of a wheel that describe it: METADATA, WHEEL and entry points."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from catkin_pkg.package import Package as Fields
from catkin_pkg.package import parse_package_string

from launcher.base.errors import LauncherError
from launcher.base.program import program
from launcher.workspace.building.sources import Package
from launcher.workspace.building.wheel.archive import WheelEntry
from launcher.workspace.building.wheel.contents import WheelContents


def fields_of(package: Package) -> Fields:
    if package.manifest is None:
        raise LauncherError(
            f"{package.name} has no package.xml, from which a wheel gets its name and version",
            hint=f"{program()} pkg create makes a package with one",
        )
    source = package.manifest.source
    return parse_package_string(source.text, filename=source.path)


def entries(
    fields: Fields,
    contents: WheelContents,
    tag: str,
    requirements: Sequence[str],
    legal: Sequence[WheelEntry],
) -> list[WheelEntry]:
    """The files of the folder `dist_info`."""
    folder = dist_info(fields)
    text = _metadata(fields, contents, requirements, legal)
    is_pure = "false" if contents.python or not tag.endswith("-any") else "true"
    wheel = f"Wheel-Version: 1.0\nGenerator: launcher\nRoot-Is-Purelib: {is_pure}\nTag: {tag}\n"
    found = [
        WheelEntry(f"{folder}/METADATA", text.encode()),
        WheelEntry(f"{folder}/WHEEL", wheel.encode()),
        *(WheelEntry(f"{folder}/licenses/{one.name}", one.source) for one in legal),
    ]
    if contents.entry_points:
        found.append(WheelEntry(f"{folder}/entry_points.txt", contents.entry_points.encode()))
    return found


def stem(fields: Fields) -> str:
    return f"{fields.name.replace('-', '_')}-{fields.version}"


def dist_info(fields: Fields) -> str:
    return f"{stem(fields)}.dist-info"


def _metadata(
    fields: Fields,
    contents: WheelContents,
    requirements: Sequence[str],
    legal: Sequence[WheelEntry],
) -> str:
    description = " ".join(fields.description.split())
    people = [(one.name, one.email) for one in fields.maintainers]
    rows = [
        ("Metadata-Version", "2.4"),
        ("Name", fields.name),
        ("Version", fields.version),
        ("Summary", textwrap.shorten(description, 200, placeholder=" ...")),
        *(("Project-URL", f"{one.type or 'website'}, {one.url}") for one in fields.urls),
        ("Author", ", ".join(one.name for one in fields.authors)),
        ("Maintainer", ", ".join(name for name, email in people if not email)),
        ("Maintainer-email", ", ".join(f"{name} <{email}>" for name, email in people if email)),
        ("License", ", ".join(map(str, fields.licenses))),
        *(("License-File", one.name) for one in legal),
        ("Requires-Python", f"=={contents.python}.*" if contents.python else ""),
        *(("Requires-Dist", one) for one in requirements),
        ("Description-Content-Type", "text/plain; charset=UTF-8"),
    ]
    lines = [f"{key}: {' '.join(value.split())}" for key, value in rows if value]
    return "\n".join([*lines, "", description, ""])
