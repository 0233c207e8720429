"""The part database: parts with their tags in one embedded file, JSON exchange, and parts from meshes."""

from rfcompass.recordings.parts.database import PartDatabase
from rfcompass.recordings.parts.exchange import PartCollection, read_parts, write_parts
from rfcompass.recordings.parts.mesh import part_from_mesh

__all__ = ["PartCollection", "PartDatabase", "part_from_mesh", "read_parts", "write_parts"]
