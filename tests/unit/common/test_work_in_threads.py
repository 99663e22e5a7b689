"""Work in threads."""

import threading
import time

import pytest

from fecontact.halfspace.fft import default_threads, each


@pytest.mark.parametrize(("asked", "expected"), [("3", 3), ("2,4", 2), (" 1 ", 1)])
def test_the_number_of_threads_is_that_of_the_numerical_libraries(monkeypatch, asked, expected):
    monkeypatch.setenv("OMP_NUM_THREADS", asked)
    assert default_threads() == expected


@pytest.mark.parametrize("asked", ["", "0", "-2", "many"])
def test_otherwise_it_is_that_of_the_cores(monkeypatch, asked):
    monkeypatch.setenv("OMP_NUM_THREADS", asked)
    cores = default_threads()
    monkeypatch.delenv("OMP_NUM_THREADS")
    assert cores == default_threads() >= 1


def test_results_are_in_order_whatever_thread_ends_first():
    def slow_first(n):
        time.sleep(0.02 if n == 0 else 0.0)
        return n, threading.get_ident()

    found = each(slow_first, range(6), threads=3)
    assert [n for n, _ in found] == list(range(6))
    assert threading.get_ident() not in {thread for _, thread in found}


def test_one_thread_or_one_item_needs_no_other_thread():
    here = threading.get_ident()
    assert each(lambda _: threading.get_ident(), range(3), threads=1) == [here] * 3
    assert each(lambda _: threading.get_ident(), [0], threads=4) == [here]


def test_errors_of_threads_are_raised_here():
    with pytest.raises(ZeroDivisionError):
        each(lambda n: 1 / n, [1, 0, 1], threads=2)
