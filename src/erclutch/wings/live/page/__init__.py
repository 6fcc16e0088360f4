"""The page's server runs on this machine alone, in a process of its own. It shows a session and takes its commands.

`access` says who gets an answer, `ring_summary` what the ring tells beside the curves, `wire` how frames travel.
`page_server` puts them together, `page_process` starts the server and hands commands back to the session.
"""
