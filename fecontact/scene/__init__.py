"""Solution procedures: small motion, local search, finite rotation, sweeps."""
