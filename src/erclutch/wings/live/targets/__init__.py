"""Each file is a target of the registry's group ``erclutch.targets``."""
