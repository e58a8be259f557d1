"""The interpreter turns a launch description into effects, step by step. It does no I/O.

How a driver uses it::

    from launcher.language.compat import vocabulary
    from launcher.language import frontends
    from launcher.language.interpreter import Interpreter

    with vocabulary([path, "name:=value"]):  # `import launch` works while this is open
        description = frontends.load(path)   # LaunchFileError: file:line, exit code 2
        interpreter = Interpreter(description, path=path, arguments=[("name", "value")])
        try:
            effects = interpreter.start()    # the whole static part; LaunchFileError
            while running:
                for effect in effects:       # carry them out in order (launcher.base.model.events)
                    ...                      # e.g. StartProcess -> remember effect.process_id
                effects = interpreter.handle(event)   # ProcessStarted, ProcessExited, TimerFired
        finally:
            interpreter.close()              # deletes generated files, restores os.environ

`handle` never raises for a fault of the launch file: it sets `interpreter.failure` and requests
the shutdown of the system, as ROS 2 does. After ProcessExited(will_restart=True) the action
continues, and ProcessStarted follows each restart. Ctrl-C is `handle(SignalReceived(...))`,
any other reason to end the run `handle(ShutdownAsked(...))`: the effects include
RequestShutdown. A StartProcess after a RequestShutdown comes from an OnShutdown handler: start it
and do not stop it. When no process is left, the interpreter requests the shutdown itself
(reason `idle`). `watches_output(process_id)`: whether the launch file handles the output of a
process. `warnings` holds those of `launcher.language.diagnostics.ros2_quirks`.
"""

from launcher.language.interpreter.interpreter import Interpreter

__all__ = ["Interpreter"]
