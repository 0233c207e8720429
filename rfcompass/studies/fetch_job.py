"""What every fetch is, in a simulated room or with a robot behind a socket: what is sought, steps, tries, stops."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from planners.fetch import FetchStep
from planners.pick_up import GraspTrial
from rfcompass.robots import Robot
from rfcompass.simulation import RecordedStop
from rfcompass.types.parts import Part


@dataclass(frozen=True, slots=True)
class ReportedStep:
    """A step of the loop, as it is told while it runs.

    Attributes:
        step: What the robot knows.
    """

    step: FetchStep


class Sought(Protocol):
    """Who fetches what."""

    @property
    def robot(self) -> Robot:
        """The robot."""
        ...

    @property
    def part(self) -> Part:
        """What lies on the floor."""
        ...

    @property
    def tags(self) -> int:
        """Number of tags on the part, K."""
        ...

    @property
    def spacing(self) -> str:
        """Which placement of K tags."""
        ...


class FetchJob(Protocol):
    """One fetch, from the start until the part is in the hand."""

    @property
    def stops(self) -> Sequence[RecordedStop]:
        """All stops for this part so far, one whose localisation failed included."""
        ...

    def steps(self) -> Iterator[ReportedStep]:
        """Navigate to the part and localise it.

        Raises:
            NoAnswer: If the loop ends without the part; the subclass says why.
        """
        ...

    def pick_up(self, found: ReportedStep) -> Iterator[ReportedStep | GraspTrial]:
        """Grasp the part.

        Args:
            found: The last step of `steps`.

        Raises:
            NoAnswer: If the part is not in the hand at the end; the subclass says why.
        """
        ...
