"""What a test asks of a refusal: its class, its code and what it was about, not its sentence."""

from contextlib import contextmanager

import pytest


@contextmanager
def refused(kind, code, *said):
    """The block raises an error of the class, or one of the classes, with the code; its message contains all texts."""
    with pytest.raises(kind) as caught:
        yield caught
    assert caught.value.code == code, str(caught.value)
    assert not [text for text in said if text not in str(caught.value)], str(caught.value)
