"""Each file is a command of the registry's group ``erclutch.commands``."""
