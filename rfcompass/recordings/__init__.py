"""Recorded reads: the trace store and importers of foreign logs."""

from rfcompass.recordings.adarf import import_adarf
from rfcompass.recordings.antenna_poses import AntennaPoses
from rfcompass.recordings.importers import IMPORTERS, importer
from rfcompass.recordings.meta_json import SCHEMA
from rfcompass.recordings.parts import PartCollection, PartDatabase, part_from_mesh, read_parts, write_parts
from rfcompass.recordings.read_table import reads_table
from rfcompass.recordings.run_folder import VIEW_FILE, Run, check_target, is_run, write_run
from rfcompass.recordings.stops import Stops
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import TraceMeta, TraceTag
from rfcompass.recordings.trace_quality import StrayTag, TagQuality, TraceQuality
from rfcompass.recordings.trace_store import open_trace, write_trace

__all__ = [
    "IMPORTERS",
    "SCHEMA",
    "VIEW_FILE",
    "AntennaPoses",
    "PartCollection",
    "PartDatabase",
    "Run",
    "Stops",
    "StrayTag",
    "TagQuality",
    "Trace",
    "TraceMeta",
    "TraceQuality",
    "TraceTag",
    "check_target",
    "import_adarf",
    "importer",
    "is_run",
    "open_trace",
    "part_from_mesh",
    "read_parts",
    "reads_table",
    "write_parts",
    "write_run",
    "write_trace",
]
