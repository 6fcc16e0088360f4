"""Figures for papers are one file a figure, at IEEE column width, with embedded fonts and the numbers behind them."""
