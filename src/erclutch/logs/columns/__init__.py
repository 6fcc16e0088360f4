"""What the columns of a table say of themselves: by their names, their units and the shapes of their numbers.

`seen_columns` gathers it once for a plan; `candidates` lists the columns that may be a signal. Nothing is chosen here.
"""
