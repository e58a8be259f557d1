"""Packages that are built like well-known ones, with the real tools."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.support import public_packages as public
from tests.support.workspaces import build, run

# Those whose build files differ most, and what they need.
CHOSEN = (
    public.FOXGLOVE_MSGS,
    public.GEOGRAPHIC_MSGS,
    public.NAV2_COMMON,
    public.NAV2_MSGS,
)


@pytest.mark.thorough
def test_public_packages_are_built_and_their_types_found(tmp_path: Path):
    for package in CHOSEN:
        package.write(tmp_path / "src")
    assert f"{len(CHOSEN)} built" in build(tmp_path)
    command = [sys.executable, "-m", "launcher", "interface", "show"]
    shown = run([*command, "nav2_msgs/action/FollowGPSWaypoints"], cwd=tmp_path)
    assert "geographic_msgs/GeoPoint[] gps_poses\n\tfloat64 latitude" in shown
    assert "Color[] colors" in run([*command, "foxglove_msgs/msg/Line"], cwd=tmp_path)
    build(tmp_path)  # the build of foxglove_msgs has written into its sources
    assert f"{len(CHOSEN)} unchanged" in build(tmp_path)
