"""How two surfaces are coupled: nodal forces or mortar, and which side is the slave."""
