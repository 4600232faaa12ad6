"""What the tests of the module weft share."""

import numpy as np
import pytest

import weft


@pytest.fixture
def box():
    return weft.box(3)


@pytest.fixture
def sizes(box):
    return np.full(len(box.points), 0.2)
