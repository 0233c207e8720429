"""Logs that name channels: carriers come from the reader's own table, and from nothing else."""

import pytest

from rfcompass.errors import ImportFormatError
from rfcompass.recordings.channel_log import channels
from rfcompass.recordings.text_table import TextTable


def table(**columns):
    return TextTable("log.csv", columns, ImportFormatError)


def test_channels_take_their_carriers_from_the_table():
    index, freq_hz, outside = channels(table(c=["2", "1", "3", "0", "-1"]), "c", (905e6, 903e6))
    assert index.tolist() == [2, 1, 3, 0, -1]
    assert freq_hz[:2].tolist() == [903e6, 905e6]
    assert outside.tolist() == [False, False, True, True, True]


def test_channels_without_a_table_are_an_error_rather_than_a_guess():
    with pytest.raises(ImportFormatError, match="table"):
        channels(table(c=["1"]), "c", ())


@pytest.mark.parametrize("freq_hz", [902.75, 902_750.0, 902.75e12, 0.0, -902.75e6, float("nan"), float("inf")])
def test_a_table_in_some_other_unit_is_an_error(freq_hz):
    with pytest.raises(ImportFormatError, match="no UHF carrier"):
        channels(table(c=["1"]), "c", (902.75e6, freq_hz))
