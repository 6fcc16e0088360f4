"""Models compute with this: the exported C's functions, derivatives, number formats, the record of a step."""
