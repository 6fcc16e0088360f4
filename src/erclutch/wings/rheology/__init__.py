"""Laws of shear stress are fitted to flow curves of a rheometer."""
