"""Electronic product codes: the one spelling in which they are compared.

An EPC is 96 bits that a tag reports about itself. What those bits mean is up to whoever wrote the tag; only
codes that begin with a header of the GS1 tag data standard can be decoded further. Libraries for that standard
(epcpy, pyepc) reject every other code, also those of laboratory tags, hence the rule here is the plain one:
24 hexadecimal digits.
"""

import re

from rfcompass.errors import InputError

_SEPARATORS = re.compile(r"[\s-]")
_CODE = re.compile(r"[0-9a-f]{24}")


def canonical_epc(text: str) -> str:
    """Return an EPC as 24 lower-case hexadecimal digits.

    Args:
        text: 96 bits in hexadecimal; upper case, spaces and dashes are accepted.

    Raises:
        InputError: If it is anything else; carries `epc`.
    """
    if not isinstance(text, str):
        raise InputError(f"{text!r} is no EPC: it must be text", epc=text)
    digits = _SEPARATORS.sub("", text).lower()
    if not _CODE.fullmatch(digits):
        message = f"{text!r} is no 96-bit EPC: 24 hexadecimal digits are needed, here are {len(digits)} characters"
        raise InputError(message, epc=text, characters=len(digits))
    return digits
