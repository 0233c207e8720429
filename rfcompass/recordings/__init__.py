"""Recorded reads: the trace store and importers of foreign logs."""

from rfcompass.recordings.adarf import import_adarf
from rfcompass.recordings.antenna_poses import AntennaPoses
from rfcompass.recordings.carriage import Carriage, CarrierLog, StillAntennas
from rfcompass.recordings.importers import IMPORTERS, import_log, importer
from rfcompass.recordings.itemtest import import_itemtest
from rfcompass.recordings.llrpkit_csv import import_llrpkit
from rfcompass.recordings.meta_json import SCHEMA
from rfcompass.recordings.parts import PartCollection, PartDatabase, part_from_mesh, read_parts, write_parts
from rfcompass.recordings.read_table import reads_table
from rfcompass.recordings.recorder import Recording, record
from rfcompass.recordings.run_folder import VIEW_FILE, Run, check_target, is_run, write_run
from rfcompass.recordings.sllurp_csv import import_sllurp
from rfcompass.recordings.spool_trace import import_spool
from rfcompass.recordings.stops import Stops
from rfcompass.recordings.stored_estimate import read_estimate
from rfcompass.recordings.stored_plan import PlanSetting, read_plan, read_plan_setting
from rfcompass.recordings.task_folder import TaskRun, check_task_target, is_task, write_task
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import TraceMeta, TraceTag
from rfcompass.recordings.trace_quality import StrayTag, TagQuality, TraceQuality
from rfcompass.recordings.trace_store import open_trace, write_trace

__all__ = [
    "IMPORTERS",
    "SCHEMA",
    "VIEW_FILE",
    "AntennaPoses",
    "Carriage",
    "CarrierLog",
    "PartCollection",
    "PartDatabase",
    "PlanSetting",
    "Recording",
    "Run",
    "StillAntennas",
    "Stops",
    "StrayTag",
    "TagQuality",
    "TaskRun",
    "Trace",
    "TraceMeta",
    "TraceQuality",
    "TraceTag",
    "check_target",
    "check_task_target",
    "import_adarf",
    "import_itemtest",
    "import_llrpkit",
    "import_log",
    "import_sllurp",
    "import_spool",
    "importer",
    "is_run",
    "is_task",
    "open_trace",
    "part_from_mesh",
    "read_estimate",
    "read_parts",
    "read_plan",
    "read_plan_setting",
    "reads_table",
    "record",
    "write_parts",
    "write_run",
    "write_task",
    "write_trace",
]
