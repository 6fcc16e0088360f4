"""The name of a current or a voltage says that it is of a machine: a drive, or what loads the device or is tested.

Such a current makes a torque in a motor, and no field in a fluid: it is doubted, or told from the field by its course.
"""

from __future__ import annotations

import re

from erclutch.logs.columns.names import SpokenName
from erclutch.logs.columns.vocabulary import set_of

#: Words of a drive in the name of its current (i_q, q_current, motor_current), and of the current beside it.
_OF_DRIVES = set_of(
    "motor mot servo drive iq isq q motorstrom servostrom antriebsstrom moteur motore двигателя двигатель мотора "
    "silnika silnik motoru motora moottorin moottori servomotor servomoteur"
)
#: The same inside Eastern compounds; what only begins like that is a generator or an armature.
_IN_DRIVES = re.compile("(?<!发)电机|(?<![发發発])電機(?!子)|马达|モータ|電動機|모터|전동기")
#: Words of a machine that loads the device, or is itself under test; an eddy-current brake has a load current too.
_OF_MACHINES = set_of(
    "load generator gen dut uut armature absorber alternator anker ankerstrom generatorstrom "
    "armadura inducido induzido induit indotto armatura generador gerador generatore generateur generatrice "
    "alternateur alternador alternatore якоря генератора twornika generatora prądnicy kotvy enduvi"
)
_IN_MACHINES = re.compile("电枢|電枢|電機子|전기자|发电机|發電機|発電機|발전기")


def is_of_a_drive(spoken: SpokenName) -> bool:
    """Whether a name is that of a drive's own quantity, in the languages that people write."""
    return spoken.says(_OF_DRIVES) or bool(_IN_DRIVES.search(spoken.stem))


def is_of_a_machine(spoken: SpokenName) -> bool:
    """Whether a name is that of a machine which loads the device or is under test."""
    return spoken.says(_OF_MACHINES) or bool(_IN_MACHINES.search(spoken.stem))
