"""Each file is a reader of the registry's group ``erclutch.readers``: exports of rheometers with several tests."""
