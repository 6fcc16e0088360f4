"""Reports and figures take their numbers from here: what a run's rows and models say. Nothing is drawn here."""
