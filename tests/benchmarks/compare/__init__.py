"""Speed against error: methods compared on problems with a known answer, and beside other programs.

One method more is one function with `methods.method`; one problem more is one maker in `problems`.
"""
