"""Scenes from the input decks of other programs: Abaqus, CalculiX and FEBio."""
