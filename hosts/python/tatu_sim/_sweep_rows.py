"""Rows of a sweep, and files of rows."""

import json
import logging
import os
import weakref
from collections.abc import Sequence as _Sequence
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Tuple, Union

from . import _native

try:
    import fcntl
except ImportError:  # Windows: two sweeps that write to the same file are not detected.
    fcntl = None  # type: ignore[assignment]

PathLike = Union[str, "os.PathLike[str]"]
Row = Dict[str, Any]

logger = logging.getLogger("tatu_sim")

#: Fields of rows that depend on the machine and its load.
MACHINE = ("wall_s", "host", "pid")
#: Suffixes of the supported types of files.
JSONL, PARQUET = ".jsonl", ".parquet"

_encode = json.JSONEncoder(ensure_ascii=False).encode


class CheckError(_native.Error):
    """The same job yielded different rows. `rows` are the two rows, with host and process."""

    rows: Tuple[Row, Row]

    @classmethod
    def of(cls, a: Row, b: Row) -> "CheckError":
        names = sorted(name for name in {**a, **b} if name not in MACHINE and a.get(name) != b.get(name))
        e = cls(
            f"the job {a['key']} gave different rows: {', '.join(names) or 'nothing'} differ\n"
            + "\n".join(f"  on {row.get('host')}, process {row.get('pid')}: {json.dumps(plain(row))}" for row in (a, b))
            + "\nhelp: are the same program and plugins installed on all machines, and does a script use anything "
            "besides the scene and its seed, such as files?"
        )
        for name in ("code", "text", "help", "file", "line"):
            setattr(e, name, None)
        e.text = f"the job {a['key']} gave different rows"
        e.rows = (a, b)
        return e


def plain(row: Mapping[str, Any]) -> Row:
    """Return a row without the fields that depend on the machine."""
    return {name: value for name, value in row.items() if name not in MACHINE}


class Rows(_Sequence):
    """Rows of a sweep, sorted by key: a list of dicts as `tatu sweep` writes them, one for each distinct job.

    `key`, `seed`, `set`, `steps`, `time`, `metrics`, `hash` and `faults` depend only on the scene and the job;
    `wall_s`, `host` and `pid` are the duration, machine and process. A failed job has `error` instead of results.
    `rows[KEY]` is the row with that key; `keys` are the keys of the jobs in the order in which they were given.
    """

    def __init__(self, rows: Iterable[Row], keys: Optional[Iterable[str]] = None):
        self._rows: List[Row] = sorted(rows, key=lambda row: row["key"])
        self._by_key = {row["key"]: row for row in self._rows}
        self.keys: List[str] = [row["key"] for row in self._rows] if keys is None else list(keys)

    @classmethod
    def read(cls, *files: PathLike) -> "Rows":
        """Read the rows of one or more files, `.jsonl` or `.parquet`, such as those of the tasks of a job array.

        Raises:
            CheckError: Two files contain different rows for the same job.
        """
        rows: Dict[str, Row] = {}
        for file in files:
            for row in read_file(Path(file)):
                old = rows.get(row["key"])
                if old is not None and "error" not in old and "error" not in row and plain(old) != plain(row):
                    raise CheckError.of(old, row)
                merge(rows, row)
        return cls(rows.values())

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, str):
            return self._by_key[index]
        return Rows(self._rows[index]) if isinstance(index, slice) else self._rows[index]

    def __iter__(self) -> Iterator[Row]:
        return iter(self._rows)

    def __eq__(self, other: Any) -> bool:
        return self._rows == list(other) if isinstance(other, (Rows, list, tuple)) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        failed = len(self.errors)
        return f"<Rows: {len(self)}{f', {failed} with errors' if failed else ''}>"

    @property
    def errors(self) -> List[Row]:
        """The rows of failed jobs."""
        return [row for row in self._rows if "error" in row]

    def without_machine(self) -> "Rows":
        """Return the rows without wall time, host and process. The other fields do not depend on where and how the
        sweep was run."""
        return Rows((plain(row) for row in self._rows), self.keys)

    def to_arrow(self) -> Any:
        """Convert to a PyArrow table. Parameters are in columns `set.KEY`, metrics in `metric.NAME`."""
        return table(self._rows)

    def to_pandas(self) -> Any:
        """Convert to a pandas data frame, with the columns of `to_arrow`."""
        return self.to_arrow().to_pandas()

    def write(self, file: PathLike) -> None:
        """Write a file, `.parquet` or `.jsonl`, atomically."""
        write_file(Path(file), self._rows)


def merge(rows: Dict[str, Row], row: Row) -> None:
    """Add a row. A row with an error never replaces a row without an error."""
    if "error" not in row or "error" in rows.get(row["key"], row):
        rows[row["key"]] = row


def kind(path: Path) -> str:
    """Return the type of a file, by the extension of its name."""
    if path.suffix not in (JSONL, PARQUET):
        raise ValueError(f"{path} is not a file for rows of a sweep; expected a name that ends with .jsonl or .parquet")
    return path.suffix


# ------------------------------------------------------------------------------------------------------------- tables


def table(rows: List[Row]) -> Any:
    """Convert rows to a PyArrow table."""
    import pyarrow as pa

    names: Dict[str, Dict[str, None]] = {"set": {}, "metrics": {}}
    for row in rows:
        for part, all_names in names.items():
            all_names.update(dict.fromkeys(row.get(part) or ()))
    fields, columns = [], []

    def add(name: str, type_: Any, value: Callable[[Row], Any]) -> None:
        fields.append(pa.field(name, type_))
        columns.append(pa.array(map(value, rows), type_))

    add("key", pa.string(), lambda row: row["key"])
    add("seed", pa.uint64(), lambda row: row.get("seed"))
    for name in sorted(names["set"]):
        field, column = _parameter(name, [(row.get("set") or {}).get(name) for row in rows])
        fields.append(field)
        columns.append(column)
    add("steps", pa.int64(), lambda row: row.get("steps"))
    add("time", pa.float64(), lambda row: row.get("time"))
    for name in sorted(names["metrics"]):
        add(f"metric.{name}", pa.float64(), lambda row: (row.get("metrics") or {}).get(name))
    add("hash", pa.string(), lambda row: row.get("hash"))
    add("faults", pa.int64(), lambda row: row.get("faults"))
    if any("error" in row for row in rows):
        add("error", pa.string(), lambda row: row.get("error"))
    for name, type_ in zip(MACHINE, (pa.float64(), pa.string(), pa.int64())):
        if any(name in row for row in rows):
            add(name, type_, lambda row: row.get(name))
    return pa.Table.from_arrays(columns, schema=pa.schema(fields))


def _parameter(name: str, values: List[Any]) -> Tuple[Any, Any]:
    """Return the column of a parameter: of the values' common type if there is one, otherwise of JSON strings."""
    import pyarrow as pa

    def kind_of(value: Any) -> str:
        if isinstance(value, (list, tuple)):
            inner = {kind_of(v) for v in value}
            return "list" if inner <= {"int", "float"} else "json"
        return type(value).__name__

    kinds = {kind_of(value) for value in values if value is not None}
    types = {"bool": pa.bool_(), "int": pa.int64(), "str": pa.string()}
    type_ = None
    if kinds == {"list"}:
        type_ = pa.list_(pa.float64())
    elif len(kinds) == 1:
        type_ = types.get(*kinds)
    if kinds and kinds <= {"int", "float"} and kinds != {"int"}:
        type_ = pa.float64()
    if type_ is not None:
        try:
            return pa.field(f"set.{name}", type_), pa.array(values, type_)
        except (pa.ArrowInvalid, OverflowError):
            pass
    texts = [None if value is None else json.dumps(value) for value in values]
    return pa.field(f"set.{name}", pa.string(), metadata={"json": "true"}), pa.array(texts, pa.string())


def rows_of(table: Any) -> List[Row]:
    """Convert a PyArrow table to rows."""
    rows: List[Row] = [{} for _ in range(table.num_rows)]
    if not {"key", "seed", "steps", "time", "hash", "faults"} <= set(table.column_names):
        raise ValueError("the columns key, seed, steps, time, hash and faults are required, but some are missing")
    for field in table.schema:
        part, dot, name = field.name.partition(".")
        is_json = (field.metadata or {}).get(b"json") == b"true"
        for row, value in zip(rows, table.column(field.name).to_pylist()):
            if part == "set" and dot:
                if value is not None:
                    row.setdefault("set", {})[name] = json.loads(value) if is_json else value
            elif part == "metric" and dot:
                row.setdefault("metrics", {})[name] = value
            elif value is not None or field.name == "seed":
                row[field.name] = value
    for row in rows:
        row.setdefault("set", {})
        if "error" in row:
            row.pop("metrics", None)
        else:
            row.setdefault("metrics", {})
    return rows


# -------------------------------------------------------------------------------------------------------------- files


def read_file(path: Path) -> List[Row]:
    """Read the rows of a file, in file order."""
    if kind(path) == JSONL:
        return read_lines(path, path.read_bytes())[0]
    import pyarrow.parquet

    try:
        return rows_of(pyarrow.parquet.read_table(path))
    except ValueError as e:
        raise ValueError(f"{path} cannot be read as rows of a sweep: {e}") from e


def read_lines(path: Path, data: bytes) -> Tuple[List[Row], int]:
    """Return the rows in JSON lines, and the length of these lines in bytes. An incomplete last line is ignored."""
    rows: List[Row] = []
    whole = 0
    while whole < len(data):
        end = data.find(b"\n", whole)
        line = data[whole : end if end >= 0 else len(data)]
        row = _row(line) if end >= 0 else None
        if row is None and line.strip():
            if 0 <= end < len(data) - 1:
                line_number = data.count(b"\n", 0, whole) + 1
                raise ValueError(
                    f"{path}, line {line_number}: this is not a row of a sweep; use another file, or remove the line "
                    "so that its job is run again"
                )
            break
        if row is not None:
            rows.append(row)
        whole = end + 1
    return rows, whole


def _row(line: bytes) -> Optional[Row]:
    try:
        row = json.loads(line)
    except ValueError:
        return None
    return row if isinstance(row, dict) and isinstance(row.get("key"), str) else None


def write_file(path: Path, rows: List[Row]) -> None:
    """Write rows to a file atomically."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        if kind(path) == PARQUET:
            import pyarrow.parquet

            pyarrow.parquet.write_table(table(rows), part)
        else:
            with open(part, "w", encoding="utf-8") as file:
                file.writelines(_encode(row) + "\n" for row in rows)
        with open(part, "rb+") as file:
            os.fsync(file.fileno())
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


#: Output files that this process has open.
_outputs: "weakref.WeakSet[Output]" = weakref.WeakSet()


def _forked() -> None:
    """Close inherited files in a pool process, which would otherwise keep them locked after the parent has died."""
    for output in list(_outputs):
        output._file.close()
        _outputs.discard(output)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)


class Output:
    """A file that is filled while a sweep runs, and which a later sweep can continue.

    Rows are appended as JSON lines to the file itself or, for a Parquet file, to a file next to it, from which the
    Parquet file is written at the end.
    """

    def __init__(self, path: PathLike):
        self.path = Path(path)
        self.journal = self.path
        if kind(self.path) == PARQUET:
            import pyarrow  # noqa: F401  If it is missing, this must fail now and not after hours of work.

            self.journal = self.path.with_name(self.path.name + JSONL)
        #: All rows of the file by key, including those of other sweeps.
        self.rows: Dict[str, Row] = {}
        if self.journal != self.path and self.path.exists():
            self._add(read_file(self.path))
        self._file = self._open()
        try:
            data = self._file.readall()
            rows, whole = read_lines(self.journal, data)
            if whole < len(data):
                logger.warning("%s: its last line is incomplete and is removed", self.journal)
                self._file.truncate(whole)
            self._file.seek(whole)
            self._add(rows)
            _outputs.add(self)
        except BaseException:
            self._file.close()
            raise

    def _add(self, rows: Iterable[Row]) -> None:
        for row in rows:
            merge(self.rows, row)

    def _open(self) -> Any:
        while True:
            file = os.fdopen(os.open(self.journal, os.O_RDWR | os.O_CREAT, 0o666), "rb+", buffering=0)
            if fcntl is None:
                return file
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                file.close()
                raise BlockingIOError(f"{self.journal}: another sweep is writing this file") from None
            except OSError:
                return file  # A file system without locks.
            # The other sweep may have replaced the file between opening and locking it.
            if os.path.exists(self.journal) and os.path.samestat(os.fstat(file.fileno()), os.stat(self.journal)):
                return file
            file.close()

    def write(self, rows: List[Row]) -> None:
        """Append rows to the file, and to `rows`."""
        self._add(rows)
        data = "".join(_encode(row) + "\n" for row in rows).encode()
        while data:
            data = data[self._file.write(data) :]

    def sync(self) -> None:
        """Wait until the rows are on disk."""
        os.fsync(self._file.fileno())

    def finish(self) -> None:
        """Write the complete file, sorted by key."""
        if self._file.closed:
            return
        self.sync()
        rows = [self.rows[key] for key in sorted(self.rows)]
        write_file(self.path, rows)
        if self.journal != self.path:
            self.journal.unlink()
        _outputs.discard(self)
        self._file.close()
