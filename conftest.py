"""Configuration of every test run, doctests included: one thread for each process, as several processes test at once.

Threads of a few microseconds' work each cost more than they do, most of all where processes outnumber the cores. The
libraries read these variables when they are loaded, so this stands where pytest comes by before anything imports them.
Whatever is set already stays. `tests/unit/scene/test_sweep_processes.py` runs with two threads all the same.
"""

import os
import sys

assert "numpy" not in sys.modules, "a plugin has loaded numpy before the number of its threads was set"

for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")
