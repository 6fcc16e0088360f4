"""Wings stand on the core and could come from another package: the core imports none of them.

A wing is a folder with its code and, by the names of the registry's groups, what it brings: `commands`, `targets`.
"""
