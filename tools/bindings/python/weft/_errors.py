"""What weft raises: one class for each status of the C interface."""


class Error(Exception):
    """Base of all errors of weft."""


class UsageError(Error, TypeError):
    """An argument of a kind that makes no sense: no array, a dtype, a missing order=."""


class InputError(Error, ValueError):
    """Data that cannot be used. The text names file or array, entity or index, and the reason; in a run on several
    ranks the rank too."""


class OptionError(Error, ValueError):
    """An option that is unknown, makes no sense or contradicts another; it is named as by the command."""


class RunError(Error, RuntimeError):
    """A run on several ranks came to no end, because a rank has died or something failed on one."""


class OutOfMemory(Error, MemoryError):
    """There is not enough memory."""


class InternalError(Error, RuntimeError):
    """A fault of weft."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended an adaptation. `result` is what the call would have returned: it has a valid mesh."""

    result = None
