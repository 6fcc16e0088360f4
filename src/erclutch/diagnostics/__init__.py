"""The numbers behind reports and figures: what a run's rows and models say. No drawing here."""
