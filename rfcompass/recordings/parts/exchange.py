"""Files of parts: JSON of schema `rfcompass-parts/1`, for editing, sending and keeping under version control."""

import json
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rfcompass.errors import DuplicateEpc, PartError
from rfcompass.files import write_text_atomic
from rfcompass.recordings.parts.node import Node, parse_document
from rfcompass.recordings.parts.part_json import assembly_content, parse_assembly, parse_part, part_content
from rfcompass.types.parts import Assembly, Part
from rfcompass.types.record import Record

SCHEMA = "rfcompass-parts/1"

# A list of numbers as json.dumps indents it; a text cannot hold its line breaks.
_NUMBERS = re.compile(r"\[\n([\s\d.,e+-]*)\]")


@dataclass(frozen=True, slots=True)
class PartCollection(Record):
    """What a file of parts holds.

    Attributes:
        parts: Parts; no id and no EPC stands twice.
        assemblies: Products made of parts. Their parts need not be in the collection.
    """

    parts: tuple[Part, ...] = ()
    assemblies: tuple[Assembly, ...] = ()

    def __post_init__(self) -> None:
        """Check that ids, EPCs and names are unique."""
        _check_unique([part.part_id for part in self.parts], "part")
        _check_unique([assembly.name for assembly in self.assemblies], "assembly")
        owners: dict[str, str] = {}
        for part in self.parts:
            for epc in part.tags.epcs:
                if epc in owners:
                    message = f"EPC {epc} is on part {owners[epc]} and on part {part.part_id}"
                    raise DuplicateEpc(message, epc=epc, parts=[owners[epc], part.part_id])
                owners[epc] = part.part_id


def _check_unique(names: Sequence[str], what: str) -> None:
    for name, count in Counter(names).items():
        if count > 1:
            raise PartError(f"{what} {name} stands {count} times", name=name)


def collection_text(collection: PartCollection) -> str:
    """Write a collection; equal collections give equal text."""
    content = {
        "schema": SCHEMA,
        "parts": [part_content(part) for part in collection.parts],
        "assemblies": [assembly_content(assembly) for assembly in collection.assemblies],
    }
    text = json.dumps(content, indent=1, allow_nan=False)
    return _NUMBERS.sub(lambda numbers: f"[{' '.join(numbers[1].split())}]", text) + "\n"


def parse_collection(text: str, file: str) -> PartCollection:
    """Read the text of a file of parts.

    Args:
        text: JSON.
        file: Name of the file, for errors.

    Raises:
        InputError: If it is no JSON, of another schema, incomplete or impossible; carries `file` and `key`.
    """
    document = parse_document(text, file)
    schema = document.entries().get("schema", Node(None, file, "schema"))
    if schema.value != SCHEMA:
        raise schema.defect(f"is {schema.value!r}, expected {SCHEMA!r}")
    content = document.fields(("schema", "parts"), ("assemblies",))
    with document.naming():
        return PartCollection(
            tuple(parse_part(item) for item in content["parts"].items()),
            tuple(parse_assembly(item) for item in content.get("assemblies", Node([], file)).items()),
        )


def read_parts(path: Path) -> PartCollection:
    """Read a file of parts.

    Raises:
        InputError: If it cannot be read, is no JSON, of another schema, incomplete or impossible.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as cause:
        raise PartError(f"{path.name}: cannot be read: {cause}", file=path.name) from cause
    return parse_collection(text, path.name)


def write_parts(path: Path, collection: PartCollection) -> None:
    """Write a file of parts. It appears whole or not at all.

    Raises:
        PartError: If it cannot be written.
    """
    try:
        write_text_atomic(path, collection_text(collection))
    except OSError as cause:
        raise PartError(f"{path.name}: cannot be written: {cause}", file=path.name) from cause
