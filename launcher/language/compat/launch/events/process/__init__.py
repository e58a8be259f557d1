"""`launch.events.process`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "ProcessExited": "launcher.language.process_events",
    "ProcessIO": "launcher.language.process_events",
    "ProcessStarted": "launcher.language.process_events",
    "ProcessStderr": "launcher.language.process_events",
    "ProcessStdin": "launcher.language.process_events",
    "ProcessStdout": "launcher.language.process_events",
    "ProcessTargetedEvent": "launcher.language.process_events",
    "RunningProcessEvent": "launcher.language.process_events",
    "ShutdownProcess": "launcher.language.process_events",
    "SignalProcess": "launcher.language.process_events",
    "matches_executable": "launcher.language.process_events",
    "matches_name": "launcher.language.process_events",
    "matches_pid": "launcher.language.process_events",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
