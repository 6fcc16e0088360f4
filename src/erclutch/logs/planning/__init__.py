"""A plan is made of a table, a step a file: `whole_plan` calls the steps one after another and is where to begin."""
