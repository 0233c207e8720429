"""Two studies for the registry's tests."""

from toy_study import toy_study

FIRST = toy_study(name="first")
SECOND = toy_study(name="second")
