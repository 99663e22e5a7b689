"""The procedures that solve a scene: small motion, local search, finite rotation, sweeps."""
