"""Faces divided with a marked one: those that touch it."""

import numpy as np

from fecontact.scene.marking import _divided_with


def test_error_is_counted_with_the_first_face_that_a_face_touches():
    # a row of five quadrilaterals between nodes 0..5 and 10..15, the middle one first
    facets = np.array([[k, k + 1, k + 11, k + 10] for k in (2, 4, 0, 3, 1)])
    misfit = np.array([16.0, 8.0, 4.0, 2.0, 1.0])
    # the middle face takes its neighbours 3 and 1 with it; of the others each stands alone
    assert _divided_with(facets, misfit).tolist() == [19.0, 8.0, 4.0, 0.0, 0.0]
    assert _divided_with(facets[:0], misfit[:0]).tolist() == []
