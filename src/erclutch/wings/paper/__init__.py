"""The paper's tables, sweeps and runs are repeated on the digital TWIN by default, on a user's log just as well."""
