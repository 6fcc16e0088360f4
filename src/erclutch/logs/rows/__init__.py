"""Rows of a table are told apart: by material or test, by signal, by level of the field, by what no sensor measured."""
