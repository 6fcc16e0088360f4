"""The generated C has its pieces, its printer, and the compilers that run it here."""
