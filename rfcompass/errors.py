"""Every exception of the project.

Two families, which the command line turns into exit codes: [`InputError`][rfcompass.errors.InputError]
(what was handed in is wrong, exit 2) and [`NoAnswer`][rfcompass.errors.NoAnswer] (the input is fine, but
physics or data do not allow an answer, exit 1). An error carries the numbers that explain it as
`error.numbers`, so that a program can act on them without parsing the message.
"""

from typing import Self


class RfCompassError(Exception):
    """Base of all our exceptions.

    Args:
        message: One sentence for a human, with the numbers in it.
        **numbers: The same evidence for a program, for example `epc="3008…"` or `reads=0`.
    """

    def __init__(self, message: str, **numbers: object) -> None:
        """Keep the message for people and the numbers for programs."""
        super().__init__(message)
        self.message = message
        self.numbers = numbers

    @property
    def kind(self) -> str:
        """Stable name of the failure, as printed by `--json`."""
        return type(self).__name__

    def __reduce__(self) -> tuple[object, ...]:
        """Survive the trip between worker processes with all evidence."""
        return _rebuild, (type(self), self.message, self.numbers)

    def with_numbers(self, **numbers: object) -> Self:
        """Return the same error with more evidence, for callers that know the context."""
        return type(self)(self.message, **{**self.numbers, **numbers})


def _rebuild(cls: type[RfCompassError], message: str, numbers: dict[str, object]) -> RfCompassError:
    return cls(message, **numbers)


class InputError(RfCompassError, ValueError):
    """What was handed in is wrong: a file, a column, a URDF, an argument."""


class ShapeError(InputError):
    """An array has the wrong shape, type or values; `name`, `expected` and `got` say which."""


class TraceError(InputError):
    """A trace folder breaks the format; carries `file` and, where known, `column` and `row`."""


class ImportFormatError(InputError):
    """A foreign log could not be read; carries `file` and, where known, `column` and `row`."""


class DegenerateAnchors(InputError):
    """The anchors do not define any comparison: fewer than two, or two in the same place."""


class DuplicateEpc(InputError):
    """One EPC names two tags; carries `epc`."""


class StudyError(InputError):
    """A study is unknown, or a folder holds the rows of another study."""


class UnknownPart(InputError):
    """No part, assembly or tag of that name is in the database; carries the name and those `near` to it."""


class PartError(InputError):
    """A part, a mesh or a file of parts cannot be; carries, where known, `part`, `file` and `key`."""


class PartDatabaseError(InputError):
    """The file of a part database is damaged, foreign, of another version or locked; carries `file`."""


class RobotModelError(InputError):
    """A URDF, a tag layout or a robot description cannot be used; carries, where known, `file` and what is wrong."""


class JointLimitError(InputError):
    """A joint value is outside its limits; carries `joint`, `value`, `lower` and `upper`."""


class UnknownRobot(InputError):
    """No robot or tag layout of that name is known; carries `name` and those that are `known`."""


class UnsuitablePath(InputError):
    """The antenna path does not suit the method: bent, too short; carries the length that is wrong."""


class SceneError(InputError):
    """A scene, a room or what stands in it cannot be; carries, where known, the `key` and what was `got`."""


class PileError(InputError):
    """A pile, one of its items or a pile file cannot be; carries, where known, the `file`, `key` and what was `got`."""


class PlanFileError(InputError):
    """A file of a grasp plan breaks the format, or holds a failure; carries `file` and, where known, `key`."""


class EstimateError(InputError):
    """A stored estimate cannot be read or used; carries `file` and, where known, the `key`."""


class RobotFormatError(InputError):
    """What travels over a robot link breaks its format; carries, where known, the `key` and the command's `id`."""


class UnknownMeter(InputError):
    """No proximity meter of that name; carries `meter` and those that are `known`."""


class TargetTooLarge(InputError):
    """The target cannot lie in the workspace; carries `longest_m` and the workspace's `diagonal_m`."""


class NoAnswer(RfCompassError):
    """The input is in order, but does not allow an answer."""


class TagNeverHeard(NoAnswer):
    """An EPC that was asked for has no read; carries `epc` and `heard`."""


class NoEstimate(NoAnswer):
    """A run ended without an estimate; carries `file` and the `failure` that it ended with."""


class NotFocused(NoAnswer):
    """Phases do not fit what was asked of them; carries how well they fit and what was `needed`."""


class NotInView(NoAnswer):
    """Cameras see too few markers of a body; carries the `body`, the `markers` in view and how many are `needed`."""


class CameraBlocked(NoAnswer):
    """A camera sees nothing, or only what stands right before it; carries `seen` pixels and their `median_m`."""


class ArmStopped(NoAnswer):
    """An arm stopped in the middle of a job, and goes on only once somebody has looked; carries `during` what."""


class NothingHidden(NoAnswer):
    """Views looked into every voxel that they reached: nothing can be hidden; carries how many `voxels`."""


class NothingToGrasp(NoAnswer):
    """A view of a pile shows no object, or none that the hand could close on; carries how many `masks` there were."""


class NotLocated(NoAnswer):
    """A tag is not located well enough for what was asked, or not where it was asked for; carries `epc`."""


class TooFewReads(NoAnswer):
    """A tag was heard too rarely to locate or compare it; carries `epc`, `reads` and `needed`."""


class TooFewPairs(NoAnswer):
    """Too few pairs of anchors were measured to judge a meter; carries `pairs` and `needed`."""


class Infeasible(NoAnswer):
    """The constraints contradict each other; carries `rows` and the last `epsilon` tried."""


class SolverFailed(NoAnswer):
    """A numerical solver stopped without a verdict; carries its `status`."""


class NoPile(NoAnswer):
    """No pile of the wanted kind came out; carries the `tries`, and how many ended at which `stage`."""


class PileUnsettled(NoAnswer):
    """Items do not come to rest, or the simulation blew up; carries the time `simulated_s` and the `creep_m` left."""


class PileChanged(NoAnswer):
    """A pile made anew from its seed is not the stored one; carries both hashes and the versions that made them."""


class OutOfReach(NoAnswer):
    """The arm cannot go there; carries the target and the smallest `miss_m` found."""


class GraspFailed(NoAnswer):
    """The part is not in the hand; carries the `reason`, and how many `tries` were made."""


class DeliveryFailed(NoAnswer):
    """A part was put down short of where it was to go; carries `short_m`."""


class NoRoomForTags(NoAnswer):
    """There are not as many places for tags as asked for; carries how many were `placed`."""


class MissingExtra(InputError):
    """An optional dependency is not installed; carries the `extra` that brings it."""


class NoBrowser(NoAnswer):
    """No browser is installed that takes a picture of a page, or it drew nothing; carries what it `said`."""


class ReaderError(NoAnswer):
    """A live reader gives no reads; carries `host` and `port`."""


class LinkLost(ReaderError):
    """There is no connection to the reader, or it broke; a later attempt may succeed."""


class MalformedFrame(LinkLost):
    """What the reader sent is no LLRP; carries `bytes` and, where known, the message `type`."""


class ReaderRefused(ReaderError):
    """The reader refused a request, or lacks what we need; carries, where known, `status` and `request`."""


class RobotLinkError(NoAnswer):
    """A robot behind a link does not do what it was asked; carries `host` and `port`."""


class RobotLost(RobotLinkError):
    """There is no connection to the robot, or it broke, or no answer came in time.

    Carries the `command` and `id` that are unanswered, if any: nobody knows yet whether the robot did it.
    """


class RobotFrameError(RobotLost):
    """What the robot's side sent is no frame of the protocol, or too long; the connection was closed."""


class RobotSchemaError(RobotLinkError):
    """The other side speaks another protocol or version; carries its `schema` and the one `expected`."""


class RobotRefused(RobotLinkError):
    """The robot refused or failed a command; carries the `command` and the `reason`."""


class RobotBusy(RobotRefused):
    """The robot has another client, or still carries out what an earlier one wanted."""


class NothingRecorded(NoAnswer):
    """A recording ended without a single read that could be kept; carries the counts."""
