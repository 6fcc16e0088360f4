"""The numbers behind reports and figures: what a run's residuals say, from its rows and models alone. No drawing here."""
