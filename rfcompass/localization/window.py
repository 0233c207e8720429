"""How far back the localizer looks: odometry slips, so old stops are worth less [Wang2013], section 4.3."""

from collections.abc import Sequence

from rfcompass.errors import InputError
from rfcompass.types.observation import Observation

MAX_MOTIONS = 3
MAX_TRAVEL_M = 2.0


def recent_stops(
    observations: Sequence[Observation], max_motions: int = MAX_MOTIONS, max_travel_m: float = MAX_TRAVEL_M
) -> tuple[Observation, ...]:
    """Keep the newest stops: "three consecutive motions of the robot and across at most 2 m" [Wang2013], section 4.3.

    Each motion, of the base or of the hand, ends in one stop, so three motions are three stops. Travel is the
    length of the base's path from a stop to the newest one, straight between stops; hand motions add nothing.

    Args:
        observations: Stops in the order they were made, newest last; base poses in one odometry frame.
        max_motions: Largest number of stops to keep.
        max_travel_m: Longest path of the base back from the newest stop [m].

    Returns:
        The kept stops, newest last; always at least the newest one.

    Raises:
        InputError: If there is no observation, or `max_motions` is below 1.
    """
    if not observations:
        raise InputError("no observation was given", observations=0)
    if max_motions < 1:
        raise InputError(f"a window of {max_motions} motions holds no stop", max_motions=max_motions)
    kept, travel_m = [observations[-1]], 0.0
    for older in reversed(observations[:-1]):
        motion = older.base_pose.inverse() @ kept[0].base_pose
        travel_m += float((motion.x_m**2 + motion.y_m**2) ** 0.5)
        if len(kept) == max_motions or travel_m > max_travel_m:
            break
        kept.insert(0, older)
    return tuple(kept)
