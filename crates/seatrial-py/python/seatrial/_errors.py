"""Exceptions with the exit codes of the command."""


class SeatrialError(Exception):
    """Something went wrong; ``code`` is the exit code that the command has for it. 1 is a bug."""

    code: int = 1


class UsageError(SeatrialError, ValueError):
    """Arguments that do not make sense."""

    code = 2


class InputError(SeatrialError):
    """Input that cannot be read or understood."""

    code = 3


class RejectedError(SeatrialError):
    """Input that was understood but gives no result; ``reason`` is the verdict's code where there is one."""

    code = 4
    reason: str = ""


class AbortedError(SeatrialError):
    """A trial that was aborted."""

    code = 5


class NotSavedError(SeatrialError, OSError):
    """Finished, but something could not be saved."""

    code = 6


class SeatrialWarning(UserWarning):
    """What has to be known before a result is trusted."""
