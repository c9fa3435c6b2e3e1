"""Columns of equal length."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray


class Table(Mapping[str, Any]):
    """Named columns of equal length: ``table["energy"]`` is an array, ``table[["a", "b"]]`` a table of two columns.

    Columns of numbers are numpy arrays, columns of lists and texts are lists. ``table.energy`` is ``table["energy"]``.
    """

    def __init__(self, columns: Mapping[str, Any]) -> None:
        """``columns``: arrays and lists of equal length by name."""
        self._columns = dict(columns)

    @overload
    def __getitem__(self, name: str) -> Any: ...
    @overload
    def __getitem__(self, name: list[str]) -> Table: ...
    def __getitem__(self, name: str | list[str]) -> Any:
        """The column ``name``, or a table of the columns in a list of names. ``KeyError``: there is no such column."""
        if isinstance(name, list):
            return Table({each: self._columns[each] for each in name})
        return self._columns[name]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self._columns:
            raise AttributeError(f"no column is called {name!r}: the columns are {', '.join(self.__dict__['_columns'])}")
        return self._columns[name]

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._columns]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def rows(self) -> int:
        """Number of rows. (``len`` is the number of columns.)"""
        return len(next(iter(self._columns.values()), []))

    def where(self, mask: NDArray[np.bool_] | Sequence[bool]) -> Table:
        """The rows at which ``mask``, of shape (rows,), is true; a copy. ``IndexError``: the mask is too long."""
        chosen = np.flatnonzero(np.asarray(mask))
        return Table({
            name: values[chosen] if isinstance(values, np.ndarray) else [values[row] for row in chosen]
            for name, values in self._columns.items()
        })

    def _plain(self) -> dict[str, Any]:
        return {
            name: list(values) if isinstance(values, np.ndarray) and values.ndim > 1 else values
            for name, values in self._columns.items()
        }

    def to_pandas(self) -> Any:
        """The table as a ``pandas.DataFrame``."""
        import pandas

        return pandas.DataFrame(self._plain())

    def to_polars(self) -> Any:
        """The table as a ``polars.DataFrame``."""
        import polars

        return polars.DataFrame(self._plain())

    def to_arrow(self) -> Any:
        """The table as a ``pyarrow.Table``."""
        import pyarrow

        return pyarrow.table(self._plain())

    def __repr__(self) -> str:
        return f"Table of {self.rows} rows: {', '.join(self._columns)}"
