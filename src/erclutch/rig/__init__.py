"""The rig as an interface, and the digital TWIN behind it: two coaxial ER clutches on a ball screw.

``scenarios.prepare("training").columns()`` gives a log; `twin.Twin` is the same rig stepped at 1 kHz.
"""
