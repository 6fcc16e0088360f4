"""The report: one self-contained HTML file from a run folder alone, sections one class and one template each."""
