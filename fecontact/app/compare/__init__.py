"""Speed against error: methods compared on problems with a known answer, and beside other programs.

One method more is one function with `methods.method`; one problem more is one maker in `problems`.
"""

from fecontact.app.compare.methods import METHODS, Measured, Method, default_variants, method
from fecontact.app.compare.peers import Peer, find_peers
from fecontact.app.compare.problems import PROBLEMS, Problem, problem
from fecontact.app.compare.run import Plan, compare

__all__ = [
    "METHODS",
    "PROBLEMS",
    "Measured",
    "Method",
    "Peer",
    "Plan",
    "Problem",
    "compare",
    "default_variants",
    "find_peers",
    "method",
    "problem",
]
