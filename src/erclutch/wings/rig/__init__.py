"""The rig is an interface; behind it stands the digital TWIN: two coaxial ER clutches on a ball screw.

``scenarios.prepare("training").columns()`` gives a log; `twin.Twin` is the same rig stepped at 1 kHz.
"""
