"""Two depths of one suite, and tests that take long.

`make test` leaves out what is marked `full`; `make check` runs everything. Of the cases of a test marked `by_day`,
those that it names, or every so many, are run by both, the others by `make check` only. A test without these marks
that takes longer than a number of matrix products, timed in the same run, is listed at the end and fails `make check`.
"""

import os
import time

import numpy as np
import pytest

#: Matrix products that a test not marked `full` may take the time of: 3 s where one takes 45 ms.
PRODUCTS, SIZE = 65, 1000
COST, BEGUN = pytest.StashKey[float](), pytest.StashKey[float]()


def pytest_addoption(parser):
    parser.addoption("--no-slow", action="store_true", help="fail if a test takes long and is not marked full")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    met = {}
    for item in items:
        if hasattr(item, "callspec") and item.callspec.params.get("rounding", 0) > 1:  # one change by day
            item.add_marker(pytest.mark.full)
        if marker := item.get_closest_marker("by_day"):
            case = _case(item.callspec)
            cases = met.setdefault(item.nodeid.partition("[")[0], (set(marker.args), []))[1]
            cases += [] if case in cases else [case]
            every = marker.kwargs.get("every")
            if cases.index(case) % every if every else case not in marker.args:
                item.add_marker(pytest.mark.full)
    wrong = {test: left for test, (names, cases) in met.items() if (left := names - set(cases))}
    if wrong and not any("::" in argument for argument in config.args):
        raise pytest.UsageError(f"by_day names what is no case: {wrong}")


def _case(callspec):
    """Name of a case without its change by rounding, which stands before or after it, empty where there is none."""
    if (change := callspec.params.get("rounding")) is None:
        return callspec.id
    name = f"rounding{change}" if change else ""
    return callspec.id.removeprefix(f"{name}-").removesuffix(f"-{name}")


def _spent():
    """Processor time of this process and of those that it has started and awaited."""
    return sum(os.times()[:4])


def product():
    """Processor time of one product of matrices, the least of five."""
    matrix, times = np.ones((SIZE, SIZE)), []
    for _ in range(5):
        begin = time.process_time()
        matrix @ matrix
        times.append(time.process_time() - begin)
    return min(times)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    item.stash[BEGUN] = _spent()
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    spent = _spent() - item.stash[BEGUN]
    if call.when == "teardown" and spent > 1.0 and item.get_closest_marker("full") is None:
        if COST not in item.config.stash:
            item.config.stash[COST] = product()
        report.user_properties.append(("products", spent / item.config.stash[COST]))
    return report


def _slow(reporter):
    """Costs and names of tests that take longer than a test of every day may."""
    reports = [report for kind in reporter.stats.values() for report in kind if isinstance(report, pytest.TestReport)]
    costs = {(dict(report.user_properties).get("products", 0.0), report.nodeid) for report in reports}
    return sorted((found for found in costs if found[0] > PRODUCTS), reverse=True)


def pytest_terminal_summary(terminalreporter):
    if slow := _slow(terminalreporter):
        terminalreporter.section(f"slow and not marked full: over {PRODUCTS} products of matrices")
        for cost, test in slow:
            terminalreporter.write_line(f"{cost:6.0f} {test}")


def pytest_sessionfinish(session):
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if session.config.getoption("no_slow") and reporter is not None and _slow(reporter) and not session.exitstatus:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
