"""The program: standard files, Ctrl-C and closed pipes, before anything else is imported."""

INTERRUPTED = 130

try:
    import codecs
    import gc
    import os
    import signal
    import sys

    # Python notices a Ctrl-C where a function begins, which no `try` of main covers. Until
    # main has begun, one ends the process without a word; also where a shell has ignored it for
    # us because of `&`.
    if signal.getsignal(signal.SIGINT) in (signal.default_int_handler, signal.SIG_IGN):
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    from launcher.posix import dispositions

    dispositions.take_over()
except KeyboardInterrupt:  # imports are where a Ctrl-C is noticed
    raise SystemExit(INTERRUPTED) from None


def open_standard_files() -> None:
    """Put /dev/null where 0, 1 or 2 is closed: the next file opened would take its place."""
    for fd in range(3):
        try:
            os.fstat(fd)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115  (for good)


def _replacement(error: UnicodeError) -> tuple[str | bytes, int]:
    from launcher.posix.stdio import replacement

    return replacement(error)


def print_all_characters() -> None:
    """Replace what the encoding of standard output lacks (LC_ALL=C, latin-1), which is an error.

    Another handler than Python's own was chosen with PYTHONIOENCODING. Standard error escapes.
    """
    codecs.register_error("launcher", _replacement)
    if sys.stdout.errors in ("strict", "surrogateescape"):
        sys.stdout.reconfigure(errors="launcher")  # type: ignore[union-attr]


def run() -> int:
    """The whole command; Ctrl-C before the first process ends it silently."""
    try:
        # What is made on the way to the first process stays, so collecting would find nothing;
        # the supervisor enables it again, and so does every verb that supervises nothing.
        gc.disable()
        from launcher.cli.dispatch import main

        return main(sys.argv[1:])
    except KeyboardInterrupt:
        return INTERRUPTED
    except RuntimeError as error:
        if isinstance(error.__cause__, KeyboardInterrupt):  # in __set_name__, before Python 3.12
            return INTERRUPTED
        raise
    except BrokenPipeError:
        return 0  # the reader of the output has gone


def flushed(code: int) -> int:
    """The exit code after the output is flushed; a reader that has gone is no failure."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        except OSError as error:
            from launcher.posix.stdio import report_lost_output

            report_lost_output(error, stream)
            code = code or 1
    return code


def main() -> int:
    """The command `launcher`; the exit code."""
    try:
        if signal.getsignal(signal.SIGINT) is signal.SIG_DFL:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        dispositions.repeat_dropped_signals()
        open_standard_files()
        print_all_characters()
        return flushed(run())
    except KeyboardInterrupt:
        return INTERRUPTED


def launch_test() -> int:
    """The program `launch_test` of ROS 2: the verb `launch-test`."""
    sys.argv.insert(1, "launch-test")
    return main()


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:  # noticed after the last line of main
        sys.exit(INTERRUPTED)
