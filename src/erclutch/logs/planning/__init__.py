"""A plan is made of a table, a rule after another: `whole_plan` lists the rules and is where to begin."""
