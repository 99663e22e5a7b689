"""Make docs/gallery.md anew: every example run as a script, its pictures with captions, and what it prints.

make gallery                                      (all of them)
python docs/gallery.py --only pin_in_bore         (these run, of the others the text is written anew)
"""

from __future__ import annotations

import argparse
import ast
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from PIL import Image
from tqdm import tqdm

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "gallery.md"
IMAGES = ROOT / "docs" / "images" / "gallery"


@dataclass(frozen=True)
class Entry:
    """A run of an example, and the captions of the pictures that are shown of it."""

    script: str
    captions: dict[str, str] = field(default_factory=dict)
    arguments: tuple[str, ...] = ()

    @property
    def called(self) -> str:
        """Script and arguments, as on the command line."""
        return " ".join([f"examples/{self.script}.py", *self.arguments])


#: Examples, from the shortest script to the largest scene.
SHOWN: tuple[Entry, ...] = (
    Entry(
        "coated_rough",
        {
            "coated_rough": "Pressure, gap and displacement of the surface, and von Mises stress in the plane through "
            "the largest pressure, with the coating's lower face as a line. Asperities raise the peak to 4.5 GPa, "
            "twice that of a smooth ball, and the stress below them: 2.3 GPa in the coating at its lower face, 0.005 "
            "mm deep, where a smooth ball has 0.5 GPa. From some 0.06 mm on, where the ball's own stress is largest, "
            "1.4 GPa, they are not felt.",
        },
    ),
    Entry(
        "pin_in_bore",
        {
            "pin_in_bore": "The bore's wall under the pin, the edge of the contact in blue: 141 MPa at the peak, "
            "where Hertz has 142 MPa for a pin in the groove of a half-space. The contact is a tenth wider than "
            "Hertz's, as the flange is no half-space.",
        },
    ),
    Entry(
        "own_model",
        {
            "own_model": "Pressure on a quarter of an own block of 27-node hexahedra, by an own Gauss-Seidel "
            "solver. The peak is within 1 % of Hertz at the same force, and the package certifies the solver's "
            "residuals.",
        },
    ),
    Entry(
        "walking_knee",
        {
            "walking_knee/0002": "The pressure on both condyles at 40 % of the cycle, under 960 N. The numbers are "
            "the forces of the two regions, which share the load by the tilt that the femur has found.",
            "walking_knee/table": "Force, area and largest pressure over the cycle: the area follows the force less "
            "than in proportion, so that the peak is highest where the force is.",
        },
    ),
    Entry(
        "from_files",
        {
            "from_files": "Measured hills pressed on a half-space: the ridges carry the load, the valleys are open. "
            "The pressure is largest where the map ends, at a sharp edge. The section lies below the largest of them.",
        },
    ),
    Entry(
        "block_on_plane",
        {
            "block_on_plane": "Pressure under the block: what is left of the blue line has lifted off, as the force "
            "acts 6 mm off the middle. Which points touch is part of the answer, not of the input.",
        },
    ),
    Entry(
        "two_spheres",
        {
            "two_spheres": "Pressure along the radius and as a map, beside Hertz: 0.5 % of error in the mean over "
            "the contact, and 0.03 % with the root at its edge. A line of the mesh follows the edge of the contact.",
        },
    ),
    Entry("scene_file"),
    Entry(
        "shrink_fit",
        {
            "shrink_fit": "Von Mises stress in a quarter of hub and tyre, largest at the inner surface of each. The "
            "pressure of the seat is 25.07 MPa, 0.2 % from Lame's, with six elements around the quarter.",
        },
    ),
    Entry(
        "partial_slip",
        {
            "partial_slip": "Tractions of friction on half of the contact: the middle sticks (blue) within 0.089 mm "
            "of the axis, 2.5 % from Cattaneo and Mindlin; the ring about it slides (red).",
            "partial_slip_loop": "Force against shift over a cycle: the area of the loop is the energy that "
            "fretting takes, within 1 % of Mindlin and Deresiewicz.",
        },
    ),
    Entry(
        "press_fit_torque",
        {
            "press_fit_torque": "Torque against the turn of the hub: it sticks up to 232.1 Nm, then slides as a "
            "whole. Lame's pressure times friction gives 232.2 Nm.",
        },
    ),
    Entry(
        "bracket",
        {
            "bracket_hex20": "Pressure below the bracket and below the washer: the load spreads from 175 mm² under "
            "the washer to 444 mm² on the plate. At the washer's sharp edges the pressure has no bound, so the "
            "scale ends at what most of the area keeps.",
        },
    ),
    Entry(
        "knee",
        {
            "knee_0": "Extension: the condyles share the load 820 N to 490 N, and cartilage carries 6.5 MPa at most.",
            "knee_60": "60 degrees of flexion: both contacts have moved back by 7 to 10 mm, and the force has grown "
            "to 1655 N, as ligaments tighten.",
        },
    ),
    Entry(
        "knee",
        {
            "knee_0_menisci": "Extension with menisci: five contacts in one solution. The rings take 209 N, and the "
            "peak on the cartilage falls from 6.5 to 6.1 MPa.",
        },
        ("menisci",),
    ),
    Entry(
        "hip_joint",
        {
            "hip_joint_cartilage": "The socket laid out by arcs from the centre of pressure: 3.17 MPa at most under "
            "1902 N. The contact is cut off where it reaches the rim of the socket, at the upper left.",
        },
    ),
    Entry(
        "gait",
        {
            "gait/0002": "Early stance, 448 N: the contact is an ellipse along the condyle, 180 mm², 4.8 MPa at most.",
            "gait/0014": "Swing, 100 N: half of the area and of the peak. Irregular triangles show at the edge "
            "only, where the pressure is low.",
        },
    ),
    Entry(
        "hip_stem",
        {
            "hip_stem_pressure": "Pressure of the cup on the ball, seen along the load: 11.3 MPa at most. It ends "
            "within the cup, whose rim does not touch.",
            "hip_stem_stress": "The body cut open, displacements ten times as large: the neck is bent most, 178 MPa "
            "in the stem. Along the bone the stresses are within 2.2 % of those of composite beams.",
        },
    ),
    Entry(
        "patella",
        {
            "patella": "Two regions of contact behind the kneecap, 104 N each: 200 N in all, as both walls of the "
            "groove press at an angle.",
            "patella_stress": "The kneecap on its front, with the rigid groove above it: stresses are where the "
            "contacts are, and so are the small elements.",
        },
    ),
    Entry(
        "half_space",
        {
            "half_space": "A smooth ball (0.16 % from Hertz in the mean, in 0.03 s) and a periodic rough sheet, "
            "where 4.5 % of the area carry all of the load.",
        },
    ),
    Entry(
        "report_half_space",
        {
            "report_half_space": "Forces on the cells of the report's two grids, and the pressure along a diagonal: "
            "the report's rule for a cell's own displacement errs by 6 to 7 %, Love's by 0.9 %.",
        },
    ),
    Entry(
        "beam_on_half_space",
        {
            "beam_on_half_space": "Pressure under one half of the bar for four ratios of stiffness: the stiffer the "
            "bar, the farther it stays down. The lengths are the same for any force.",
        },
    ),
    Entry(
        "rough_block",
        {
            "rough_block": "The same rough ball on a thin block and on a half-space, 512 x 512 cells: asperities "
            "look alike, but the plate below the block takes a third off the approach.",
        },
    ),
    Entry(
        "plain_faces",
        {
            "plain_faces": "With a ninth node (above) the pressure is Hertz's, and a uniform pressure is uniform. "
            "With the eight nodes of the plain element (below) 16 of 40 points carry nothing, at 76 % of error.",
        },
    ),
    Entry(
        "belt_drive",
        {
            "belt_drive": "Tension along the belt, and in its two spans while the pulley turns: it grows to 0.4 % "
            "from Euler and Eytelwein's ratio, and from then on the belt slides.",
        },
    ),
    Entry(
        "woven_yarns",
        {
            "woven_yarns": "Cuts of a plain weave, whose yarns along x are pulled by 2 %, and forces: these straighten "
            "and the others take over their waves and become shorter, so that the stiffness nearly doubles, "
            "towards that of a straight yarn.",
        },
    ),
    Entry(
        "inflated_tube",
        {
            "inflated_tube": "A quarter of the section at rest, inflated against a roll, and at its smallest after the "
            "pressure has gone; the force of a roll grows faster than the pressure, as ever more of the tube lies on "
            "it. Let go, the tube swings between two ovals, and its viscosity damps it.",
        },
    ),
    Entry(
        "bricks",
        {
            "bricks_circle": "Ten bricks bent by a moment at their end, up to a full circle: strain energy within "
            "0.06 % of Euler's elastica.",
            "bricks_ball": "A rigid ball pressed into a soft block by 30 % of its height: the force leaves Hertz's, "
            "which knows small strains only.",
            "bricks_strip": "A strip between two rolls that travel along it: the stress travels with them, and the "
            "force keeps within 1.5 %.",
            "bricks_bounce": "A brick dropped on its edge: the energy-momentum scheme keeps the energy to 11 "
            "digits, generalised-alpha loses 6 % of it.",
        },
    ),
)
#: Pictures wider than this are made smaller, pixels.
WIDEST = 1200


def chapter(entry: Entry, said: str) -> str:
    """Title and text of an example's docstring, its pictures with captions, its code and what it prints."""
    script = ROOT / "examples" / f"{entry.script}.py"
    title, _, rest = (ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or "").partition("\n")
    about = rest.partition("Run: ")[0].strip()
    shown = [
        f"![{picture.replace('_', ' ')}](images/gallery/{picture}.png)\n\n*{caption}*"
        for picture, caption in entry.captions.items()
    ]
    parts = [f"## {title.rstrip('.')}", about, *shown, _code(entry.script), _said(entry, said)]
    return "\n\n".join(part for part in parts if part) + "\n"


def run(entry: Entry) -> str:
    """Run an example in a folder of its own and keep its pictures; what it prints."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, str(ROOT / "examples" / f"{entry.script}.py"), *entry.arguments]
        said = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout
        for picture in entry.captions:
            save_smaller(Path(folder) / "out" / f"{picture}.png", IMAGES / f"{picture}.png")
    return said.strip("\n")


def printed_before(entry: Entry, page: str) -> str:
    """What an example printed when the page was made."""
    before = page.partition(f"Run: [`python {entry.called}`]")[0]
    return re.findall(r"^```text\n(.*?)\n```$", before, flags=re.DOTALL | re.MULTILINE)[-1]


def _code(name: str) -> str:
    """The script, folded."""
    inside = f"```{{literalinclude}} ../examples/{name}.py\n:language: python\n```"
    return f"<details><summary>The code, {name}.py</summary>\n\n{inside}\n\n</details>"


def _said(entry: Entry, said: str) -> str:
    """What the script prints, folded."""
    told = f"Run: [`python {entry.called}`](../examples/{entry.script}.py)"
    return f"<details><summary>What it prints</summary>\n\n```text\n{said}\n```\n\n</details>\n\n{told}"


def save_smaller(source: Path, target: Path) -> None:
    """Copy a picture, no wider than `WIDEST`, with a palette: drawings need no more than 256 colours."""
    target.parent.mkdir(parents=True, exist_ok=True)
    picture = Image.open(source).convert("RGB")
    picture.thumbnail((WIDEST, WIDEST))
    picture.quantize(256).save(target, optimize=True)


def main(only: list[str] | None) -> None:
    """Write the page; examples that are not among `only` keep their pictures and what they printed."""
    page = PAGE.read_text(encoding="utf-8")
    head = "# Gallery\n\nGenerated by `make gallery`: what the scripts in [examples](../examples) print and draw.\n"
    chapters = [
        chapter(entry, run(entry) if only is None or entry.script in only else printed_before(entry, page))
        for entry in tqdm(SHOWN, unit="example", disable=None)
    ]
    PAGE.write_text("\n".join([head, *chapters]), encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    known = sorted({entry.script for entry in SHOWN})
    parser.add_argument("--only", nargs="*", choices=known, metavar="NAME", help="examples to run; without any, none")
    main(parser.parse_args().only)
