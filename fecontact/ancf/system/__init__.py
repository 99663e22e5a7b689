"""Members together: contact between them, what acts, equilibrium and motion; no member's elements are known here."""
