"""Codes of refusals: stable names, of the class where none is given, kept where an error is raised again."""

import pickle
import re
from pathlib import Path

import fecontact as fc
from fecontact import FecontactError


def test_default_and_given():
    classes = [FecontactError, fc.InputError, fc.MeshError, fc.SupportError, fc.SolverError, fc.MissingPackageError]
    codes = [kind("Why.").code for kind in classes]
    assert codes == ["error", "input", "mesh", "free-motion", "not-solved", "missing-package"]
    for kind in classes:
        found = pickle.loads(pickle.dumps(kind("Why.", code="one-of")))  # as from another process
        assert (type(found), found.code, str(found)) == (kind, "one-of", "Why.")


def test_words_with_hyphens():
    files = Path(fc.__file__).parent.rglob("*.py")
    given = [code for f in files for code in re.findall(r'\bcode="([^"]*)"', f.read_text("utf-8"))]
    assert len(given) > 400
    assert not [code for code in given if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", code)]
