"""Lines of the log files of a run."""

from __future__ import annotations

from pathlib import Path

from launcher.smoke.observe import log_files
from launcher.smoke.observe.fact_recorder import FactRecorder


def test_a_line_is_what_a_terminal_shows_of_it(tmp_path: Path):
    (tmp_path / "launch.log").write_bytes(
        b"1795866477.7142423 [bar-1] 10%\r50%\r100%\n"
        b"1795866478.0000000 [bar-1] one\xc2\x85two \x0b\x0c \xe2\x80\xa8 three\r\n"
    )
    found = log_files.lines(tmp_path, FactRecorder())
    assert [(line.process, line.text) for line in found] == [
        ("bar-1", "100%"),
        ("bar-1", "onetwo  \u2028 three"),
    ]
