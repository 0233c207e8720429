"""An EPC has one spelling, whatever it came in as."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError
from rfcompass.types.epc import canonical_epc

CODES = st.integers(0, 2**96 - 1).map(lambda code: f"{code:024x}")


@given(CODES, st.data())
def test_all_spellings_of_a_code_become_one(code, data):
    spelt = "".join(
        data.draw(st.sampled_from(["", " ", "-"])) + data.draw(st.sampled_from([digit, digit.upper()]))
        for digit in code
    )
    assert canonical_epc(spelt) == code


@given(CODES)
def test_the_canonical_spelling_stays_as_it_is(code):
    assert canonical_epc(canonical_epc(code)) == code


@pytest.mark.parametrize("code", ["942700000000000000000001", "100000000000000000000000", "3074257BF7194E4000001A85"])
def test_codes_of_laboratories_and_of_products_are_both_accepted(code):
    assert canonical_epc(code) == code.lower()


@pytest.mark.parametrize(
    "text",
    ["", "94270000000000000000001", "9427000000000000000000012", "94270000000000000000000g", "0x2700000000000000000001",
     "94270000000000000000000٣", None, 42, b"942700000000000000000001"],
)  # fmt: skip
def test_anything_else_is_refused_with_the_text_that_was_given(text):
    with pytest.raises(InputError) as caught:
        canonical_epc(text)
    assert caught.value.numbers["epc"] == text
