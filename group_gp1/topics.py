"""The topics of the fleet: every name, once."""

from __future__ import annotations

TASKS = '/fleet/tasks'
STATUS = '/fleet/status'
REPORT = '/fleet/report'
