"""Two spheres pressed together: the main job as a script, with picture and files.

Run: python examples/two_spheres.py
"""

from pathlib import Path

from fecontact.app.studies.spheres import solve_spheres


def main(level: int = 2, out: str | Path = "out") -> float:
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    study = solve_spheres("equal", level=level)
    print(study)
    study.plot(folder / "two_spheres.png")
    study.solved.save(folder / "two_spheres.json")
    return study.figures["pressure, L2"].found


if __name__ == "__main__":
    main()
