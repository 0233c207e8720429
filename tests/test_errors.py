import inspect
import pickle

import pytest

from rfcompass import errors
from rfcompass.errors import InputError, NoAnswer, RfCompassError, TagNeverHeard

ALL = [
    cls for _, cls in inspect.getmembers(errors, inspect.isclass) if issubclass(cls, RfCompassError)
]  # fmt: skip


@pytest.mark.parametrize("cls", ALL, ids=lambda cls: cls.__name__)
def test_every_error_survives_the_trip_between_processes_with_its_numbers(cls):
    error = pickle.loads(pickle.dumps(cls("tag 7 was never heard", epc="7", reads=0)))
    assert type(error) is cls
    assert (str(error), error.numbers, error.kind) == ("tag 7 was never heard", {"epc": "7", "reads": 0}, cls.__name__)


@pytest.mark.parametrize("cls", [c for c in ALL if c is not RfCompassError], ids=lambda cls: cls.__name__)
def test_every_error_is_either_bad_input_or_no_answer(cls):
    assert issubclass(cls, InputError) != issubclass(cls, NoAnswer)


def test_more_evidence_keeps_the_earlier_evidence():
    error = TagNeverHeard("never heard", epc="7").with_numbers(file="scan")
    assert error.numbers == {"epc": "7", "file": "scan"}


def test_bad_input_can_be_caught_as_value_error():
    with pytest.raises(ValueError, match="no"):
        raise InputError("no")
