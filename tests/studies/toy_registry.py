"""Studies for the tests of the registry and of the command line."""

from toy_study import hostile_toy_trial, toy_study

FIRST = toy_study(name="first")
SECOND = toy_study(name="second")
HOSTILE = toy_study(name="hostile", trial=hostile_toy_trial, factors={"noise_m": (0.1,), "method": ("bold",)})
