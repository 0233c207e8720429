"""The part database: which tags are on which part, and where on it [Wang2013], section 3.2."""

import difflib
import json
import weakref
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Self

from rfcompass.errors import DuplicateEpc, InputError, PartDatabaseError, PartError, UnknownPart
from rfcompass.recordings.parts.exchange import PartCollection, read_parts, write_parts
from rfcompass.recordings.parts.lack import lack_table
from rfcompass.recordings.parts.node import parse_document
from rfcompass.recordings.parts.part_json import parse_part, part_content
from rfcompass.recordings.parts.sqlite_file import SqliteFile, default_location
from rfcompass.types.epc import canonical_epc
from rfcompass.types.parts import Assembly, Part


class PartDatabase:
    """Parts, their tags and the products they belong to, kept in one file.

    The file is made on first use and then holds the four legs of the IKEA Lack table. Several processes may use
    it at once: a writer waits for the other, a reader sees a state from before or after. One EPC is on one part.

        leg = PartDatabase().part("table_leg_3")

    Args:
        path: File name, or `":memory:"` for a database that nobody else sees; `$RFCOMPASS_PARTS` or a file in the
            user's data folder if None.

    Raises:
        PartDatabaseError: If the file cannot be opened, is damaged, or is not a part database of this version.
    """

    def __init__(self, path: Path | str | None = None) -> None:
        """Open the file; fill it if it is new."""
        self._file = SqliteFile(default_location() if path is None else str(path))
        self._close = weakref.finalize(self, self._file.close)
        if self._file.is_empty:
            self._fill()

    def _fill(self) -> None:
        with self._file.transaction():
            if self._file.is_empty:  # nobody else was faster
                self._file.create_tables()
                self.add_collection(lack_table())

    @property
    def location(self) -> str:
        """File name, or `":memory:"`."""
        return self._file.location

    def close(self) -> None:
        """Close the file. A database that is no longer used closes by itself."""
        self._close()

    def __enter__(self) -> Self:
        """Use the database in a `with` statement, which closes it."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self.close()

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """Make all changes inside happen together, or none of them if an error leaves the block."""
        with self._file.transaction():
            yield

    # Asking

    def part(self, part_id: str) -> Part:
        """Return one part.

        Raises:
            UnknownPart: If there is none of that name; names those that are spelt alike.
        """
        if not (found := self._file.rows("SELECT id, record FROM part WHERE id = ?", part_id)):
            raise self._unknown("part", part_id, self.part_ids())
        return self._as_part(*found[0])

    def part_ids(self) -> tuple[str, ...]:
        """Names of all parts, sorted."""
        return tuple(part_id for (part_id,) in self._file.rows("SELECT id FROM part ORDER BY id"))

    def parts(self) -> tuple[Part, ...]:
        """All parts, sorted by name."""
        return tuple(self._as_part(*row) for row in self._file.rows("SELECT id, record FROM part ORDER BY id"))

    def part_of_epc(self, epc: str) -> Part:
        """Return the part that carries a tag.

        Raises:
            UnknownPart: If the tag is on no part.
            InputError: If the text is no EPC.
        """
        code = canonical_epc(epc)
        query = "SELECT id, record FROM part WHERE id = (SELECT part_id FROM tag WHERE epc = ?)"
        if not (found := self._file.rows(query, code)):
            raise UnknownPart(f"tag {code} is on no part of {self.location}", epc=code, file=self.location)
        return self._as_part(*found[0])

    def assembly(self, name: str) -> tuple[Part, ...]:
        """Return the parts of a product, in the order of the assembly.

        Raises:
            UnknownPart: If there is no assembly of that name; names those that are spelt alike.
        """
        query = (
            "SELECT id, record FROM part JOIN assembly_part ON assembly_part.part_id = part.id "
            "WHERE assembly_part.assembly = ? ORDER BY place"
        )
        if not (found := self._file.rows(query, name)):
            raise self._unknown("assembly", name, tuple(assembly.name for assembly in self.assemblies()))
        return tuple(self._as_part(*row) for row in found)

    def assemblies(self) -> tuple[Assembly, ...]:
        """All products, sorted by name."""
        parts: dict[str, list[str]] = {}
        for name, part_id in self._file.rows("SELECT assembly, part_id FROM assembly_part ORDER BY assembly, place"):
            parts.setdefault(name, []).append(part_id)
        return tuple(Assembly(name, tuple(part_ids)) for name, part_ids in parts.items())

    def collection(self) -> PartCollection:
        """Everything in the database, as of one moment."""
        with self._file.transaction("BEGIN"):
            return PartCollection(self.parts(), self.assemblies())

    # Changing

    def add(self, part: Part, *, replace: bool = False) -> None:
        """Add a part, or put it in the place of the one with the same name.

        Raises:
            PartError: If a part of that name is there and `replace` is False.
            DuplicateEpc: If one of its tags is on another part.
        """
        self.add_collection(PartCollection((part,)), replace=replace)

    def add_assembly(self, assembly: Assembly, *, replace: bool = False) -> None:
        """Add a product, or put it in the place of the one with the same name.

        Raises:
            PartError: If a product of that name is there and `replace` is False.
            UnknownPart: If one of its parts is not in the database.
        """
        self.add_collection(PartCollection((), (assembly,)), replace=replace)

    def add_collection(self, collection: PartCollection, *, replace: bool = False) -> None:
        """Add parts and products, all of them or none.

        Raises:
            PartError: If one of them is there and `replace` is False.
            DuplicateEpc: If a tag is on another part.
            UnknownPart: If a product names a part that is neither here nor in the collection.
        """
        with self._file.transaction():
            self._make_room(collection, replace=replace)
            for part in collection.parts:
                self._store_part(part)
            for assembly in collection.assemblies:
                self._store_assembly(assembly)

    def remove(self, part_id: str) -> None:
        """Remove a part and its tags.

        Raises:
            UnknownPart: If there is none of that name.
            PartError: If a product still names it.
        """
        with self._file.transaction():
            users = self._file.rows("SELECT assembly FROM assembly_part WHERE part_id = ? ORDER BY 1", part_id)
            if names := [name for (name,) in users]:
                message = f"part {part_id} belongs to {', '.join(names)}; remove that first"
                raise PartError(message, part=part_id, assemblies=names)
            if not self._file.run("DELETE FROM part WHERE id = ?", part_id):
                raise self._unknown("part", part_id, self.part_ids())

    def remove_assembly(self, name: str) -> None:
        """Remove a product; its parts stay.

        Raises:
            UnknownPart: If there is none of that name.
        """
        with self._file.transaction():
            if not self._file.run("DELETE FROM assembly WHERE name = ?", name):
                raise self._unknown("assembly", name, tuple(assembly.name for assembly in self.assemblies()))

    # Files

    def import_file(self, path: Path | str, *, replace: bool = False) -> PartCollection:
        """Add what a JSON file of parts holds, all of it or nothing.

        Returns:
            What was added.

        Raises:
            InputError: If the file breaks the schema (carries `file` and `key`), or does not fit with what is here.
        """
        collection = read_parts(Path(path))
        self.add_collection(collection, replace=replace)
        return collection

    def export_file(self, path: Path | str) -> None:
        """Write everything into a JSON file of parts, which appears whole or not at all.

        Raises:
            PartError: If it cannot be written.
        """
        write_parts(Path(path), self.collection())

    def _make_room(self, collection: PartCollection, *, replace: bool) -> None:
        known_parts = set(self.part_ids())
        known_assemblies = {assembly.name for assembly in self.assemblies()}
        there = [f"part {part.part_id}" for part in collection.parts if part.part_id in known_parts]
        there += [f"assembly {item.name}" for item in collection.assemblies if item.name in known_assemblies]
        if there and not replace:
            raise PartError(f"{', '.join(there)}: already in {self.location}", names=there, file=self.location)
        for part in collection.parts:
            self._file.run("DELETE FROM tag WHERE part_id = ?", part.part_id)
        for assembly in collection.assemblies:
            self._file.run("DELETE FROM assembly WHERE name = ?", assembly.name)

    def _store_part(self, part: Part) -> None:
        for epc in part.tags.epcs:
            for (owner,) in self._file.rows("SELECT part_id FROM tag WHERE epc = ?", epc):
                message = f"EPC {epc} of part {part.part_id} is on part {owner}"
                raise DuplicateEpc(message, epc=epc, parts=[owner, part.part_id])
        record = json.dumps(part_content(part), separators=(",", ":"), allow_nan=False)
        self._file.run(
            "INSERT INTO part (id, record) VALUES (?, ?) ON CONFLICT (id) DO UPDATE SET record = excluded.record",
            part.part_id,
            record,
        )
        for epc in part.tags.epcs:
            self._file.run("INSERT INTO tag (epc, part_id) VALUES (?, ?)", epc, part.part_id)

    def _store_assembly(self, assembly: Assembly) -> None:
        known = self.part_ids()
        self._file.run("INSERT INTO assembly (name) VALUES (?)", assembly.name)
        for place, part_id in enumerate(assembly.part_ids):
            if part_id not in known:
                raise self._unknown("part", part_id, known, where=f" (named by assembly {assembly.name})")
            self._file.run("INSERT INTO assembly_part VALUES (?, ?, ?)", assembly.name, place, part_id)

    def _as_part(self, part_id: str, record: str) -> Part:
        try:
            return parse_part(parse_document(record, f"{self.location}, part {part_id}"))
        except InputError as cause:
            message = f"part database {self.location} is damaged: {cause.message}"
            raise PartDatabaseError(message, file=self.location, part=part_id) from cause

    def _unknown(self, what: str, name: str, known: Sequence[str], where: str = "") -> UnknownPart:
        near = _spelt_like(name, known)
        hint = f"; did you mean {', '.join(near)}?" if near else f"; there are {len(known)}"
        message = f"no {what} {name!r} in {self.location}{where}{hint}"
        return UnknownPart(message, name=name, near=near, file=self.location)


def _spelt_like(name: str, known: Sequence[str]) -> list[str]:
    by_lower = {candidate.lower(): candidate for candidate in known}
    return [by_lower[match] for match in difflib.get_close_matches(str(name).lower(), list(by_lower), n=4, cutoff=0.6)]
