"""Comparison with numbers of a reference to all of their printed digits."""

import numpy as np


def matches(values, printed, error=0.0):
    """Whether ``values`` round to the numbers in the text ``printed``, which are separated by commas.

    The last digit may be off by rounding, 0.51 of its unit, and by the ``error`` of the reference.
    """
    texts = [text.strip() for text in printed.split(",")]
    found = np.atleast_1d(values).ravel().tolist()
    assert len(found) == len(texts), f"{len(found)} values, {len(texts)} printed numbers"
    for value, text in zip(found, texts, strict=True):
        mantissa, _, exponent = text.partition("e")
        unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
        assert abs(value - float(text)) <= 0.51 * unit + error, f"{value!r} is not {text}"
    return True
