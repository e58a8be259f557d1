"""Where the libraries of a wheel look for others, and on which systems they run."""

from __future__ import annotations

import io
import os
import shutil
import subprocess

import pytest
from elftools.elf.elffile import ELFFile

from launcher.workspace.building.wheel.archive import WheelEntry
from launcher.workspace.building.wheel.libraries import is_library, platform, read

COMPILER = shutil.which("gcc")
pytestmark = pytest.mark.skipif(COMPILER is None, reason="compiles libraries with gcc")


@pytest.fixture
def library(tmp_path):
    def make(name, *words, text="int f(void) { return 1; }"):
        source, target = tmp_path / f"{name}.c", tmp_path / name
        source.write_text(text)
        command = [COMPILER, "-shared", "-fPIC", str(source), "-o", str(target), *words]
        subprocess.run(command, check=True, timeout=60)
        return WheelEntry(f"lib/{name}", str(target))

    return make


def runpath(entry):
    dynamic = ELFFile(io.BytesIO(entry.read())).get_section_by_name(".dynamic")
    return [tag.runpath for tag in dynamic.iter_tags("DT_RUNPATH")]


@pytest.mark.parametrize(
    ("folder", "before", "after"),
    [
        ("lib", "$ORIGIN:$ORIGIN/../../other/lib", "$ORIGIN"),
        ("lib", "/home/me/ws/install/other/lib:$ORIGIN", "$ORIGIN"),
        ("lib", "$ORIGIN/../..:$ORIGIN/../share", "$ORIGIN/../share"),
        ("lib", "$ORIGINAL:relative:${ORIGIN}/x", ""),
        ("lib/python/site-packages/p", "$ORIGIN/../../..", "$ORIGIN/../../.."),
        ("lib/python/site-packages/p", "$ORIGIN/../../../../../x/lib", ""),
    ],
)
def test_no_runpath_leads_out_of_the_prefix(library, folder, before, after):
    entry = library("liba.so", f"-Wl,--enable-new-dtags,-rpath,{before}")
    assert runpath(entry) == [before]
    changed = read(entry, folder).entry
    assert runpath(changed) == [after]
    assert len(changed.read()) == len(entry.read())


def test_names(library):
    needed = library("libb.so", "-Wl,-soname,libb.so.1")
    found = read(library("liba.so", "-Wl,--no-as-needed", needed.source), "lib")
    assert "libb.so.1" in found.needed and found.soname == "liba.so"
    assert read(needed, "lib").soname == "libb.so.1"
    assert is_library(needed) and not is_library(WheelEntry("a.py", b"print()"))


def test_a_library_of_this_machine_only(library):
    foreign = library("libforeign.so.7", "-Wl,-soname,libforeign.so.7")
    entry = library("liba.so", "-Wl,--no-as-needed", foreign.source)
    found = [read(entry, "lib")]
    tag, reason = platform(found, required=())
    assert tag == f"linux_{os.uname().machine}" and "libforeign.so.7 of this machine" in reason
    tag, reason = platform(found, required={"libforeign.so.7"})
    assert tag.startswith("manylinux_2_") and reason == ""
