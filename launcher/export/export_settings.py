"""The engines for which files are written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

from launcher.base.model.record import Record, replace
from launcher.export.compose import Compose
from launcher.export.export_model import (
    ExportedFiles,
    ExportedProcess,
    ExportedSystem,
    Unsupported,
)
from launcher.export.exported_system import gaps_of_each, merged
from launcher.export.image import files as image_files
from launcher.export.image import image_of
from launcher.export.kubernetes import Kubernetes
from launcher.export.quadlet import Quadlet
from launcher.export.readme import readme
from launcher.export.systemd import Systemd
from launcher.hosts.file.order import MAX_FILE_BYTES

if TYPE_CHECKING:
    from launcher.export.image import Image

_IN_CONTAINERS: dict[str, type[Kubernetes | Compose | Quadlet]] = {
    "kubernetes": Kubernetes,
    "compose": Compose,
    "podman": Quadlet,
}
_LOCAL = (("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"), ("ROS_LOCALHOST_ONLY", "1"))


class ExportSettings(Record):
    """What a user may choose; `image` None is `localhost/NAME`, made by the recipe."""

    user: str | None = None
    python: str = "python3"
    image: str | None = None
    shared_memory: bool = False


def export(engine: str, system: ExportedSystem, settings: ExportSettings) -> ExportedFiles:
    """All files of an export, README and image recipe included, and everything that is lost."""
    if engine == "systemd":
        output, image = Systemd(system, user=settings.user, python=settings.python).output(), None
    else:
        output, image = _in_containers(engine, system, settings)
    of_image = [] if image is None else _of_image(image)
    gaps = merged([*system.gaps, *of_image, *output.gaps])
    text = readme(engine, system, image, gaps, python=settings.python)
    recipe = {} if image is None else image_files(image)
    return ExportedFiles(files={"README.md": text, **output.files, **recipe}, gaps=gaps)


def _in_containers(
    engine: str, system: ExportedSystem, settings: ExportSettings
) -> tuple[ExportedFiles, Image | None]:
    """The files, and the image for which a recipe is written; None if the user has one."""
    name = settings.image or f"localhost/{system.name}:latest"
    writer = _IN_CONTAINERS[engine]
    output = writer(system, image=name, shared_memory=settings.shared_memory).output()
    found = gaps_of_each(system.processes, lambda one: _of_containers(one, settings))
    image = None if settings.image else image_of(name, system.packages, os.environ)
    return replace(output, gaps=(*found, *output.gaps)), image


def _of_containers(
    process: ExportedProcess, settings: ExportSettings
) -> Iterator[tuple[str, str, bool]]:
    is_local = any(process.environment.get(name) == value for name, value in _LOCAL)
    if is_local and not settings.shared_memory:
        # With this range Fast DDS uses shared memory, whatever its variable says.
        text = "containers lose all messages: export with SUBNET, or --shared-memory"
        yield "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST", text, False
    if process.host is not None and process.host.setup:
        yield "setup", "an image sources no files of the host", True
    if sum(map(len, process.files.values())) > MAX_FILE_BYTES:
        text = "more than 1 MiB of files, which a ConfigMap cannot hold: put them into the image"
        yield "files", text, False


def _of_image(image: Image) -> list[Unsupported]:
    return [
        Unsupported(
            what=f"package {package}",
            place="image",
            text="it is of an installation of ROS 2: the image lacks it",
        )
        for package in image.missing
    ]
