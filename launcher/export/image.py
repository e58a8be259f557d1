"""The recipe of a container image with the launcher and the packages of the plan."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Iterable, Iterator, Mapping
from importlib import metadata
from typing import TYPE_CHECKING

from launcher.base.errors import PackageNotFoundError
from launcher.base.model.record import Record
from launcher.packages.distribution import with_wheels
from launcher.packages.extras import DISTRIBUTION
from launcher.packages.finder import package_prefix
from launcher.packages.package_origins import wheel

if TYPE_CHECKING:
    from importlib.metadata import Distribution

_OF_SYSTEM = ("/opt/ros/", "/usr")
_REQUIREMENT = re.compile(r"([A-Za-z0-9][A-Za-z0-9._-]*)\s*(?:\[([^\]]*)\])?")
_EXTRA = re.compile(r"extra\s*==\s*[\"']([^\"']+)[\"']")


class Image(Record):
    """What an image is made of.

    `pinned` are lines of a list of requirements, `wheels` distributions that pip must get as wheels
    from the build context, `built` packages of a workspace, of which `launcher wheel` makes wheels,
    `missing` packages of an installation of ROS 2.
    """

    name: str
    python: str
    pinned: tuple[str, ...]
    wheels: tuple[str, ...]
    built: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()


def image_of(name: str, packages: Iterable[str], environ: Mapping[str, str]) -> Image:
    """The image for these ROS packages, with the versions that are installed here."""
    own = _own_distribution()
    found: dict[str, Distribution] = {}
    built, missing = [], []
    for package in sorted(set(packages)):
        distribution = _distribution(package)
        if distribution is not None:
            found[_key(package)] = distribution
        elif _is_of_system(package, environ):
            missing.append(package)
        else:
            built.append(package)
    if own is not None:
        found[_key(own.metadata["Name"])] = own
    wheels = sorted(_key(one.metadata["Name"]) for one in found.values() if _is_local(one))
    closure = _closure(found.values())
    pinned = sorted(f"{key}=={one.version}" for key, one in closure.items() if key not in wheels)
    return Image(
        name=name,
        python=f"{sys.version_info.major}.{sys.version_info.minor}",
        pinned=tuple(pinned),
        wheels=tuple(wheels),
        built=tuple(built),
        missing=tuple(missing),
    )


def _is_of_system(package: str, environ: Mapping[str, str]) -> bool:
    """Whether it is of an installation of ROS 2, or not found any more."""
    try:
        return str(package_prefix(package, environ)).startswith(_OF_SYSTEM)
    except PackageNotFoundError:
        return True


def _own_distribution() -> Distribution | None:
    """That of the launcher; None if it is not installed."""
    try:
        return metadata.distribution(DISTRIBUTION)
    except metadata.PackageNotFoundError:
        return None


def _distribution(package: str) -> Distribution | None:
    """The distribution of a ROS package; wheels of ROS are called `ros-PACKAGE`."""
    for name in (package, f"ros-{package}", wheel(package)):
        try:
            return metadata.distribution(name)
        except metadata.PackageNotFoundError:
            continue
    return None


def _is_local(distribution: Distribution) -> bool:
    """Whether it was installed from a folder or file, or is a source folder, not from an index."""
    is_installed = distribution.read_text("RECORD") is not None
    return not is_installed or distribution.read_text("direct_url.json") is not None


def _closure(roots: Iterable[Distribution]) -> dict[str, Distribution]:
    """The distributions and all that they need here, by normalised name."""
    found: dict[str, Distribution] = {}
    seen: set[tuple[str, str]] = set()
    waiting = [(one, "") for one in roots]
    waiting += [(one, with_wheels()) for one, _ in waiting if one.metadata["Name"] == DISTRIBUTION]
    while waiting:
        one, extra = waiting.pop()
        key = _key(one.metadata["Name"])
        if (key, extra) in seen:
            continue
        seen.add((key, extra))
        found[key] = one
        waiting += _needed(one, extra)
    return found


def _needed(distribution: Distribution, extra: str) -> Iterator[tuple[Distribution, str]]:
    """What a distribution needs with this extra, `` for none, each with the extras it asks for.

    Markers about the platform are not read: what they exclude is not installed.
    """
    for requirement in distribution.requires or ():
        text, _, marker = requirement.partition(";")
        wanted = _EXTRA.search(marker)
        name, extras = _REQUIREMENT.match(text.strip()).groups()  # type: ignore[union-attr]
        if (wanted[1] if wanted else "") != extra:
            continue
        try:
            found = metadata.distribution(name)
        except metadata.PackageNotFoundError:
            continue  # for another platform
        yield found, ""
        yield from ((found, one.strip()) for one in (extras or "").split(",") if one.strip())


def _key(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def files(image: Image) -> dict[str, str]:
    """The files of the build context that are made here, by path."""
    return {
        "image/Containerfile": _containerfile(image),
        "image/requirements.txt": "".join(f"{line}\n" for line in image.pinned),
    }


def _containerfile(image: Image) -> str:
    return f"""\
# The image of {image.name}; README.md has the commands that build it.
FROM python:{image.python}-slim

# With --build-arg PIP_NO_INDEX=1 only the files in wheels/ are used.
ARG PIP_NO_INDEX
ARG PIP_DISABLE_PIP_VERSION_CHECK=1
COPY requirements.txt /usr/local/share/launcher/
COPY wheels/ /tmp/wheels/
RUN python3 -m venv /opt/launcher
ENV PATH=/opt/launcher/bin:$PATH PYTHONUNBUFFERED=1
RUN pip install --no-cache-dir --find-links /tmp/wheels \\
      --requirement /usr/local/share/launcher/requirements.txt \\
 && pip install --no-cache-dir --no-deps {_wheel_words(image)} \\
 && rm -rf /tmp/wheels
# pip compiles what it installs, but the image of Python is without byte code of its library.
RUN python3 -m compileall -qq /usr/local/lib/python{image.python} || true

RUN useradd --create-home --uid 10001 launcher
# By number, so that Kubernetes can verify that it is not root.
USER 10001
WORKDIR /home/launcher
# ROS nodes end by SIGINT in order.
STOPSIGNAL SIGINT
"""


def _wheel_words(image: Image) -> str:
    if image.built:
        return "/tmp/wheels/*.whl"  # those of packages that they need are there, too
    return " ".join(f"/tmp/wheels/{name.replace('-', '_')}-*.whl" for name in image.wheels)


def build_commands(image: Image) -> list[str]:
    """Shell commands, to be run in the folder of the export."""
    lines = ["mkdir -p image/wheels"]
    lines += [f"pip wheel --no-deps --wheel-dir image/wheels SOURCE_OF_{n}" for n in image.wheels]
    if image.built:
        lines.append(f"launcher wheel --output image/wheels {shlex.join(image.built)}")
    return [*lines, f"podman build --tag {image.name} image"]
