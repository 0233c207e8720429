import json

import numpy as np
import pytest
import typer
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.arrays import plain
from rfcompass.cli.output import answering, print_json
from rfcompass.errors import InputError, TagNeverHeard

values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


@given(values)
def test_whatever_is_answered_is_json(value):
    json.loads(json.dumps(plain(value), allow_nan=False))


def test_arrays_become_lists_and_nan_becomes_null(capsys):
    print_json({"m": np.array([[1.0, np.nan]]), "n": np.int64(3), "ok": np.bool_(True)})
    assert json.loads(capsys.readouterr().out) == {"m": [[1.0, None]], "n": 3, "ok": True}


@pytest.mark.parametrize(("error", "code"), [(TagNeverHeard("never", epc="7"), 1), (InputError("wrong", file="x"), 2)])
def test_an_error_becomes_its_exit_code_a_message_and_a_failure_object(error, code, capsys):
    with pytest.raises(typer.Exit) as caught, answering(True):
        raise error
    printed = capsys.readouterr()
    assert caught.value.exit_code == code
    assert json.loads(printed.out)["failure"] == {"kind": error.kind, "message": str(error), **error.numbers}
    assert str(error) in printed.err


def test_other_errors_are_not_hidden():
    with pytest.raises(ZeroDivisionError), answering(True):
        raise ZeroDivisionError
