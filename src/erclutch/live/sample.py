"""What goes in and out of a control step beside the frame: ``erc_sample`` and ``erc_command`` in ``c/erc_layout.h``."""

from __future__ import annotations

import numpy as np

#: One reading of a rig's sensors.
SAMPLE = np.dtype(
    [
        ("seq", "<u8"),
        ("time_ns", "<u8"),
        ("theta", "<f8"),
        ("alpha", "<f8"),
        ("torque", "<f8"),
        ("status", "<u4"),
        ("unused", "<u4"),
    ]
)
#: What the rig is told.
COMMAND = np.dtype(
    [
        ("seq", "<u8"),
        ("time_ns", "<u8"),
        ("field1", "<f8"),
        ("field2", "<f8"),
        ("motor_torque", "<f8"),
        ("flags", "<u4"),
        ("unused", "<u4"),
    ]
)
