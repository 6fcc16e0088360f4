"""The page: a server on this machine alone, in a process of its own, that shows a session and takes its commands.

`access` says who gets an answer, `watcher` what the ring tells beside the curves, `wire` how frames travel, `server`
puts them together, `process` starts the server and hands commands back to the session.
"""
