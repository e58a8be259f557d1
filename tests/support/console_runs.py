"""Launch files that several tests of the console run."""

from __future__ import annotations

TICKS = """
        py("import time\\nwhile True: print('tick', flush=True); time.sleep(0.05)", name="robot_1"),
        py("import time\\nwhile True: print('tock', flush=True); time.sleep(0.05)", name="robot_2"),
        py("import time\\nwhile True: time.sleep(1)", name="monitor"),
"""
