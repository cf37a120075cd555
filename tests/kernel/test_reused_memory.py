"""Memory that large arrays give back: nobody's while anything refers to it, the next one's after that."""

import copy
import threading

import numpy as np
import pytest

from mrts.kernel.reused_memory import LARGEST, SMALLEST, arrays_in_reused_memory

MANY = 1 << 18
"""Numbers of 2^21 bytes."""


def place(array):
    return array.ctypes.data


@pytest.mark.quick
def test_memory_serves_again_once_the_last_view_has_gone():
    first, second = arrays_in_reused_memory([(MANY // 4, 2), (MANY // 2,)])
    where = place(first)
    rows = second[10:20].reshape(2, 5)  # a view of a view
    first[:] = second[:] = 1.0
    del first, second
    (other,) = arrays_in_reused_memory([(MANY,)])
    assert place(other) != where
    other[:] = 2.0
    assert np.all(rows == 1.0)
    del rows, other
    taken = [arrays_in_reused_memory([(MANY,)])[0] for _ in range(2)]
    assert where in {place(array) for array in taken}


def test_shapes_are_those_asked_for_and_arrays_do_not_overlap():
    for size in (1, 1 << (SMALLEST - 3), MANY, MANY + 1, (1 << (LARGEST - 3)) + 1):
        shapes = [(size, 3), (size,), (0, 2)]
        arrays = arrays_in_reused_memory(shapes)
        assert [array.shape for array in arrays] == shapes
        for number, array in enumerate(arrays):
            array[...] = number
        assert all(np.all(array == number) for number, array in enumerate(arrays))


def test_copies_are_their_own():
    (array,) = arrays_in_reused_memory([(MANY,)])
    array[:] = 3.0
    copies = [array.copy(), copy.deepcopy(array)]
    del array
    (other,) = arrays_in_reused_memory([(MANY,)])
    other[:] = 4.0
    assert all(np.all(one == 3.0) for one in copies)


def test_threads_never_share_memory():
    failed = []

    def work(number):
        for turn in range(50):
            arrays = arrays_in_reused_memory([(MANY,), (7,)])
            value = 1000.0 * number + turn
            for array in arrays:
                array[:] = value
            if not all(np.all(array == value) for array in arrays):
                failed.append((number, turn))

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failed == []
