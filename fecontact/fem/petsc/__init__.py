"""Contact of elastic bodies by PETSc under MPI: stiffness and displacements are shared by several processes."""
