"""This room holds the arithmetic of models: the exported C's functions, derivatives, formats, the record of a step."""
