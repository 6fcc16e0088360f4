"""Which field and motion to log next: sequences of commands within the limits of a rig."""
