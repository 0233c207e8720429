"""A leg in front of a youBot, known more or less well, for the tests of grasp planning."""

import numpy as np

from rfcompass import PartDatabase, YouBot
from rfcompass.types import Body, Box, Part, PartEstimate
from rfcompass.types.parts import no_tags

ROBOT = YouBot()
SCAN = ROBOT.posture("scan")
with PartDatabase() as database:
    LEG = database.part("table_leg_3")


def spread(sd_m, sd_deg):
    return np.diag([sd_m**2, sd_m**2, np.deg2rad(sd_deg) ** 2])


def estimate(x=0.42, y=0.03, theta=1.4, *, sd_m=0.004, sd_deg=2.0, samples=400, part=LEG, seed=1):
    """Where a part seems to lie: draws of a normal distribution; only the covariance if `samples` is 0."""
    mean, covariance = np.array([x, y, theta]), spread(sd_m, sd_deg)
    draws = np.random.default_rng(seed).multivariate_normal(mean, covariance, samples)
    return PartEstimate(
        part.part_id, mean[:2], theta, "told", 1, part.resting_height_m, covariance, samples=draws
    )  # fmt: skip


def plain_part(shape, mass_kg=0.1, name="thing"):
    return Part(name, shape, mass_kg, mass_kg * np.eye(3) * 1e-3, 0.04, no_tags(name))


def box_at(name, size_m, x, y, z, theta=0.0):
    T = np.eye(4)
    T[:2, :2] = [[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]]
    T[:3, 3] = x, y, z
    return Body(name, Box(np.array(size_m)), T)
