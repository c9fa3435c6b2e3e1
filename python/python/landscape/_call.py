"""Calls of the command line inside this process. Files and folders are written by the same code as by ``landscape``."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import Any, Union

from . import _native

StrPath = Union[str, "os.PathLike[str]"]


def main() -> int:
    """Runs the command line of this process and returns its exit code: the script ``landscape`` of this package."""
    return _native.main(["landscape", *sys.argv[1:]])


def wanted(progress: bool | None) -> bool:
    """Whether progress is shown: as given, else if standard error is a terminal."""
    return sys.stderr.isatty() if progress is None else progress


def command(*arguments: Any, progress: bool | None = None) -> str:
    """Runs a command line inside this process and returns what it prints.

    Parameters
    ----------
    arguments
        The words after ``landscape``, as in ``command("hands", "list")``. Paths and numbers are written as words.
    progress
        Whether to show progress bars on standard error; by default if it is a terminal.

    Raises
    ------
    InputError
        With the sentence that the command line would end with.
    OSError
        If a file cannot be read or written.
    """
    words = [os.fspath(word) if isinstance(word, (str, os.PathLike)) else str(word) for word in arguments]
    return _native.call(words, wanted(progress))


def flags(**given: Any) -> list[str]:
    """The flags of keyword arguments; ``None`` and ``False`` are left out. A trailing ``_`` of a name is dropped."""
    words: list[str] = []
    for name, value in given.items():
        flag = "--" + name.rstrip("_").replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            words.append(flag)
        elif isinstance(value, (list, tuple)):
            words.append(f"{flag}={','.join(str(part) for part in value)}")
        else:
            text = os.fspath(value) if isinstance(value, os.PathLike) else str(value)
            # A word that begins with a dash would be taken for a flag.
            words.extend([f"{flag}={text}"] if text.startswith("-") else [flag, text])
    return words


class Folder:
    """A temporary folder that lives as long as what uses it."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="landscape-")

    def __truediv__(self, name: str) -> Path:
        return Path(self._folder.name) / name


def existing(path: StrPath) -> Path:
    """The path of a file or folder that exists."""
    found = Path(path)
    if not found.exists():
        raise FileNotFoundError(f"{found}: there is no such file or folder")
    return found
