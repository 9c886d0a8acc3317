"""The line on which each key of a TOML text stands, so that a mistake can be located.

The text has been read by `tomllib` before, so it is well formed; this scanner only follows its shape.
"""

import re
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, field

Path = tuple[str | int, ...]


@dataclass(frozen=True)
class Places:
    """Where each key of a recipe was written, for the start of a message.

    Attributes
    ----------
    name : str
        Of the file; empty where there is none.
    lines : mapping of path to int
        From `key_lines`.
    changes : mapping of path to str
        Keys that a ``--set`` gave, and how it was typed.
    """

    name: str = ""
    lines: Mapping[Path, int] = field(default_factory=dict)
    changes: Mapping[Path, str] = field(default_factory=dict)

    def __call__(self, path: Path) -> str:
        """Say where a key was written.

        Parameters
        ----------
        path : tuple
            Of the key; the nearest table above it is told where the key itself is unknown.

        Returns
        -------
        text : str
            Such as ``"shoe.toml:12: "``; empty where nobody knows.
        """
        for length in range(len(path), 0, -1):
            if path[:length] in self.changes:
                return f"--set {self.changes[path[:length]]}: "
            if path[:length] in self.lines:
                return f"{self.name}:{self.lines[path[:length]]}: "
        return f"{self.name}: " if self.name else ""


_BARE = re.compile(r"[A-Za-z0-9_-]+")
_SPACE = re.compile(r"(?:[ \t\r\n,]|#[^\n]*)+")
_STRINGS = (
    re.compile(r'"""(?:\\.|[^\\])*?"{3,5}', re.DOTALL),
    re.compile(r"'''.*?'{3,5}", re.DOTALL),
    re.compile(r'"(?:\\.|[^"\\n])*"'),
    re.compile(r"'[^'\n]*'"),
)
_PLAIN = re.compile(r"[^,\]}#\n]+")


def key_lines(text: str) -> dict[Path, int]:
    r"""Find the line of each key.

    Parameters
    ----------
    text : str
        Well-formed TOML.

    Returns
    -------
    lines : dict of path to int
        From the path of a key, such as ``("layer", 0, "cell_size")``, to its line, counted from 1. Tables
        have the line of their header.

    Examples
    --------
    >>> key_lines('[bake]\nresolution = 64\n')
    {('bake',): 1, ('bake', 'resolution'): 2}
    """
    return _Scanner(text).document()


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text, self.at, self.lines = text, 0, dict[Path, int]()
        self.counts: dict[Path, int] = {}
        self.ends = [found.start() for found in re.finditer("\n", text)]

    def document(self) -> dict[Path, int]:
        table: Path = ()
        while self.skip_space():
            if self.text.startswith("[[", self.at):
                table = self.header("[[", "]]", repeated=True)
            elif self.text.startswith("[", self.at):
                table = self.header("[", "]", repeated=False)
            else:
                self.pair(table)
        return self.lines

    def header(self, opening: str, closing: str, *, repeated: bool) -> Path:
        line = self.line()
        self.at += len(opening)
        path = self.within_arrays(self.key())
        self.skip_space()
        self.at += len(closing)
        if repeated:
            self.counts[path] = self.counts.get(path, -1) + 1
            path = (*path, self.counts[path])
        self.lines.setdefault(path, line)
        return path

    def within_arrays(self, key: tuple[str, ...]) -> Path:
        """Say which entry of an array of tables a header below it belongs to: the last one."""
        path: Path = ()
        for i, name in enumerate(key):
            path = (*path, name)
            if path in self.counts and i < len(key) - 1:
                path = (*path, self.counts[path])
        return path

    def pair(self, table: Path) -> None:
        line = self.line()
        path = table
        for name in self.key():
            path = (*path, name)
            self.lines.setdefault(path, line)
        self.skip_space()
        self.at += 1  # the equals sign
        self.value(path)

    def key(self) -> tuple[str, ...]:
        names = []
        while True:
            self.skip_space()
            names.append(self.name())
            self.skip_space()
            if not self.text.startswith(".", self.at):
                return tuple(names)
            self.at += 1

    def name(self) -> str:
        for pattern in (_BARE, *_STRINGS[2:]):
            found = pattern.match(self.text, self.at)
            if found:
                self.at = found.end()
                return found[0].strip("\"'")
        self.at += 1
        return ""

    def value(self, path: Path) -> None:
        self.skip_space()
        if self.text.startswith("{", self.at):
            self.at += 1
            while self.skip_space() and self.text[self.at] != "}":
                self.pair(path)
            self.at += 1
        elif self.text.startswith("[", self.at):
            self.at += 1
            index = 0
            while self.skip_space() and self.text[self.at] != "]":
                self.lines.setdefault((*path, index), self.line())
                self.value((*path, index))
                index += 1
            self.at += 1
        else:
            for pattern in (*_STRINGS, _PLAIN):
                found = pattern.match(self.text, self.at)
                if found:
                    self.at = found.end()
                    return
            self.at += 1

    def skip_space(self) -> bool:
        found = _SPACE.match(self.text, self.at)
        if found:
            self.at = found.end()
        return self.at < len(self.text)

    def line(self) -> int:
        return bisect_left(self.ends, self.at) + 1
