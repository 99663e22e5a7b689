"""Keywords of Abaqus and CalculiX decks that are not used: refused, warned of, or noted, by what they change."""

from __future__ import annotations

from fecontact.app.decks.content import Remarks
from fecontact.common.errors import InputError
from fecontact.mesh.formats.abaqus_keywords import KeywordSection

#: Keywords that change the question, and how; a scene without them would answer another one.
REFUSED = {
    "TRANSFORM": "turns the axes of nodes",
    "SYSTEM": "turns coordinates",
    **dict.fromkeys(("EQUATION", "MPC", "NETWORK MPC"), "ties displacements of nodes to each other"),
    **dict.fromkeys(("COUPLING", "RIGID BODY", "DISTRIBUTING COUPLING", "KINEMATIC COUPLING"), "ties nodes to one"),
    **dict.fromkeys(("EMBEDDED ELEMENT", "SHELL TO SOLID COUPLING"), "ties elements to others"),
    **dict.fromkeys(("PRE-TENSION SECTION", "BOLT"), "pretensions a section"),
    **dict.fromkeys(("MODEL CHANGE", "CHANGE CONTACT TYPE"), "adds or removes contacts or elements in a step"),
    **dict.fromkeys(("CHANGE FRICTION", "CHANGE SURFACE BEHAVIOR"), "changes a contact in a step"),
    **dict.fromkeys(("CLEARANCE", "CONTACT INTERFERENCE"), "changes the gap of a contact"),
    **dict.fromkeys(("COHESIVE BEHAVIOR",), "makes a contact stick together"),
    **dict.fromkeys(("CONTACT", "CONTACT INCLUSIONS"), "is general contact; write each as *CONTACT PAIR"),
    **dict.fromkeys(("SUBMODEL", "SUBSTRUCTURE PROPERTY"), "takes results of another model"),
    **dict.fromkeys(("CYCLIC SYMMETRY MODEL", "PERIODIC MEDIA"), "ties one side of a sector to the other"),
    **dict.fromkeys(("USER MATERIAL", "HYPOELASTIC", "DEFORMATION PLASTICITY"), "is a law without elastic moduli"),
    **dict.fromkeys(
        ("SHELL SECTION", "SHELL GENERAL SECTION", "BEAM SECTION", "BEAM GENERAL SECTION", "MEMBRANE SECTION"),
        "gives stiffness to elements that are no solids",
    ),
    **dict.fromkeys(
        ("SPRING", "MASS", "DASHPOT", "GAP", "GAP UNIT", "CONNECTOR SECTION", "FRICTION CHANGE"),
        "gives a law to elements that are no solids",
    ),
    "SOLID SECTION": "stands inside of a step",
}
#: Keywords that ask for output.
OUTPUT = {
    "NODE PRINT", "EL PRINT", "NODE FILE", "EL FILE", "CONTACT FILE", "CONTACT PRINT", "NODE OUTPUT", "ELEMENT OUTPUT",
    "CONTACT OUTPUT", "ENERGY OUTPUT", "ENERGY FILE", "ENERGY PRINT", "OUTPUT", "SECTION PRINT", "SECTION FILE",
    "FILE FORMAT", "MONITOR", "PRINT", "PREPRINT", "RESTART", "MODAL FILE", "TIME POINTS", "FILTER",
    "INTEGRATED OUTPUT", "INTEGRATED OUTPUT SECTION",
}  # fmt: skip
#: Keywords that change how a step is solved, not its solution, or of what statics have nothing.
HARMLESS = {
    "CONTROLS", "CONTACT CONTROLS", "SOLVER CONTROLS", "SOLUTION TECHNIQUE", "CONTACT DAMPING", "DAMPING",
    "PHYSICAL CONSTANTS", "ORIENTATION", "CONDUCTIVITY", "SPECIFIC HEAT", "EXPANSION", "DEPVAR", "SURFACE",
    "HOURGLASS STIFFNESS", "SECTION CONTROLS", "TEMPERATURE", "GAP CONDUCTANCE", "GAP HEAT GENERATION",
}  # fmt: skip


def unused(s: KeywordSection, said: Remarks) -> None:
    """Note a keyword that is not used, or warn of it.

    Raises
    ------
    InputError
        If it changes the question.
    """
    if s.keyword in REFUSED:
        raise InputError(f"{s.place}: *{s.keyword} {REFUSED[s.keyword]}, which is not done here.")
    if s.keyword == "INITIAL CONDITIONS" and s.parameters.get("TYPE", "").upper() == "STRESS":
        raise InputError(f"{s.place}: *INITIAL CONDITIONS, TYPE=STRESS are not done here: bodies begin without stress.")
    beginning = s.keyword == "INITIAL CONDITIONS" and s.parameters.get("TYPE", "").upper() == "TEMPERATURE"
    if s.keyword in OUTPUT:
        said.requests.append(f"{s.place}: *{s.keyword}")
    elif s.keyword in HARMLESS or beginning:
        said.note(f"{s.place}: *{s.keyword} is not used.")
    else:
        said.warn(f"{s.place}: *{s.keyword} is not used: what it changes is left out.")


def refuse_heat(keywords: list[KeywordSection]) -> None:
    """Refuse temperatures of materials that expand.

    Raises
    ------
    InputError
        Names the keyword and its line.
    """
    if not any(s.keyword == "EXPANSION" for s in keywords):
        return
    for s in keywords:
        if s.keyword == "TEMPERATURE":
            raise InputError(f"{s.place}: *TEMPERATURE expands a material with *EXPANSION, which is not done here.")
