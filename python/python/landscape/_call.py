"""Calls of the command line inside this process. Files and folders are written by the same code as by ``landscape``."""

from __future__ import annotations

import os
import re
import sys
import tempfile
from pathlib import Path
from typing import Any, ClassVar, Union

import numpy as np

from . import _native
from ._errors import InputError

StrPath = Union[str, "os.PathLike[str]"]


def main() -> int:
    """Runs the command line of this process and returns its exit code: the script ``landscape`` of this package."""
    return _native.main(["landscape", *sys.argv[1:]])


def wanted(progress: bool | None) -> bool:
    """Whether progress is shown: as given, else if standard error is a terminal."""
    return sys.stderr.isatty() if progress is None else progress


def command(*arguments: Any, progress: bool | None = None) -> str:
    """Runs a command line inside this process and returns what it prints, the help and the version among it.

    Commands from several threads run one after the other.

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
    try:
        return _native.call(words, wanted(progress))
    except InputError as error:
        told = str(error)
    if _is_help(told):
        return f"{told}\n"
    raise InputError(_sentence(told))


def _is_help(told: str) -> bool:
    """Whether a text is the help or the version, which the parser of command lines tells like an error."""
    version = re.fullmatch(rf"landscape\S* {re.escape(_native.__version__)}", told)
    return version is not None or (not told.startswith("error: ") and "\n\nUsage: landscape " in told)


def _sentence(told: str) -> str:
    """The sentence and the tips of an error of the command line, without the paragraphs about its usage."""
    if not told.startswith("error: "):
        return told
    paragraphs = told.removeprefix("error: ").split("\n\n")
    kept = [each for each in paragraphs if not each.startswith(("Usage: ", "For more information, try "))]
    return "; ".join(" ".join(line.strip() for line in each.splitlines()) for each in kept)


def flags(**given: Any) -> list[str]:
    """The flags of keyword arguments; ``None`` and ``False`` are left out. A trailing ``_`` of a name is dropped."""
    words: list[str] = []
    for name, value in given.items():
        flag = "--" + name.rstrip("_").replace("_", "-")
        if value is None:
            continue
        if isinstance(value, (bool, np.bool_)):
            words.extend([flag] if value else [])
        elif isinstance(value, (list, tuple)):
            words.append(f"{flag}={','.join(str(part) for part in value)}")
        else:
            text = os.fspath(value) if isinstance(value, os.PathLike) else str(value)
            # A word that begins with a dash would be taken for a flag.
            words.extend([f"{flag}={text}"] if text.startswith("-") else [flag, text])
    return words


class Folder:
    """A temporary folder that lives as long as what uses it."""

    _until_the_end: ClassVar[list[Folder]] = []

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="landscape-")

    def keep(self) -> None:
        """Lets the folder live until the interpreter ends."""
        self._until_the_end.append(self)

    def __truediv__(self, name: str) -> Path:
        return Path(self._folder.name) / name


def existing(path: StrPath) -> Path:
    """The path of a file or folder that exists."""
    found = Path(path)
    if not found.exists():
        raise FileNotFoundError(f"{found}: no such file or folder")
    return found
