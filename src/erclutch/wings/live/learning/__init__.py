"""Rounds of logging, each chosen by what the law does not know after the rounds before: ``live --program learn``."""
