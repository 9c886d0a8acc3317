"""What the command prints: one line each, safe for a terminal, and never to a stream that is closed."""

import json
import sys

from surftex.errors import WorkError


def note(text: str) -> None:
    """Print a line on stderr, with the command's name before it.

    Parameters
    ----------
    text : str
        Control characters and line breaks in it are shown as escapes.
    """
    _print(f"surftex: {one_line(text)}", sys.stderr)


def out(text: str) -> None:
    """Print on stdout.

    Parameters
    ----------
    text : str
        May have several lines. Other control characters are shown as escapes, which JSON may hold as well.
    """
    _print("".join(c if c.isprintable() or c == "\n" else json.dumps(c)[1:-1] for c in text), sys.stdout)


def one_line(text: str) -> str:
    r"""Make text safe for one line of a terminal.

    Parameters
    ----------
    text : str
        Anything.

    Returns
    -------
    line : str
        Unprintable characters as escapes.

    Examples
    --------
    >>> print(one_line("a\x1b[2J\nb"))
    a\x1b[2J\nb
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _print(text: str, stream: object) -> None:
    if stream is None:  # closed by whoever started us
        return
    encoding = getattr(stream, "encoding", None) or "utf-8"
    safe = text.encode(encoding, "backslashreplace").decode(encoding)
    try:
        print(safe, file=stream)  # type: ignore[arg-type]
    except BrokenPipeError:
        raise
    except OSError as problem:
        if stream is sys.stdout:
            raise WorkError(f"cannot write to stdout: {problem.strerror}") from None
