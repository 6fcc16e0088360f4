"""A file may state above its rows what a sensor's numbers mean: counts of a turn, a torque constant, a gear's ratio.

Such a number is put into the option that asks for it, or it is asked whether the column still wants it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from math import isfinite, pi
from typing import NamedTuple

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.columns.labels import COUNTS, split_label
from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.rated_torque import (
    is_rated_torque,
    is_rating,
    share_of_rated_torque,
)
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.vocabulary import CURRENTS, DRIVES, ZEROS, set_of
from erclutch.logs.planning.draft import Draft, scaled
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

_OF_AN_ENCODER = set_of(
    "count counts cpr ppr pulse pulses tick ticks encoder enc lines impulse inkremente increments"
)
_COUNTED = _OF_AN_ENCODER - {"lines"}  # words of a column that counts
_OF_A_TURN = re.compile(
    r"(?:counts?|pulses?|ticks?|lines?|impulse|inkremente|increments)\s*(?:/|per|pro)\s*"
    r"(?:rev|revolution|turn|umdrehung|u)|cpr|ppr|striche?",
    re.IGNORECASE,
)
_FIRST_QUANTITY = re.compile(
    r"([+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)(?![\d.])\s*([^\d\s;,()][^;,()]*)?"
)
_FEWEST_COUNTS = 8  # of a turn
_OF_A_GEAR = set_of(
    "gear gearing gearbox getriebe getriebeubersetzung ubersetzung reduction reducer reduktor reductor"
)
_COUNTED_ALREADY = re.compile(r"(?:counts?|ticks?)\b", re.IGNORECASE)
_QUADRATURE = re.compile(r"quadrature|x ?4\b", re.IGNORECASE)
_RATIO = re.compile(r"(\d+(?:\.\d+)?)\s*(?::\s*(\d+(?:\.\d+)?))?")
_PLACE = re.compile(r"NUMBER ([^\"']+)/([^\"'/]+)")  # rad/s/V is of a volt
_PER = re.compile(r"_([^\W_]+)_per_([^\W_]+)$")
_MOTIONS = ("slip", "position")


class StatedScale(NamedTuple):
    """What one of a sensor's unit is, as the file states it.

    Attributes:
        said: the key and the value of the file.
        number, made: the quantity, such as 0.12 and ``N*m``.
        sensor: the unit that it stands for, ``count`` for those of an encoder.
    """

    said: str
    number: float
    made: str
    sensor: str

    def over(self, sensor: str) -> str:
        """The scale as an option has it, for a column in another unit of that sensor, too."""
        number = self.number
        if self.sensor != "count":
            factor, _ = units.fits(self.sensor, (sensor,)) or (1.0, sensor)
            number /= factor
        return f"{number:.10g} {self.made}/{sensor}"

    def is_over(self, sensor: str) -> bool:
        """Whether a column in a unit may be the numbers of that sensor."""
        if "count" in (self.sensor, sensor):
            return self.sensor == sensor
        return units.is_unit(sensor) and units.fits(self.sensor, (sensor,)) is not None


def doubt_a_position_in_counts(draft: Draft) -> None:
    """Doubt a guessed position of counts, where the file states how many of them are a turn or a length."""
    position = draft.guessed("position")
    turns = [each for each in scales_stated(draft, "position") if each.sensor == "count"]
    if position is None or position.unit is not None or len(turns) != 1:
        return
    column = draft.seen.columns[position.column]
    if column.spoken.says(_COUNTED):
        label = shell_word(draft.table.label(column.name))
        scale = shell_word(f"position={turns[0].over('count')}")
        doubt = f"in counts, and the file says {turns[0].said}"
        draft.doubt("position", doubt, f"{label} --scale {scale}")


def doubt_a_side_of_a_stated_gear(draft: Draft) -> None:
    """Doubt a guess on the motor's side beside one on the other, where the file states the ratio between them."""
    # What the file says of a gear, and how many turns of the motor are one behind it.
    ratios: list[tuple[str, float]] = []
    for key, text in draft.table.metadata.items():
        match = _RATIO.match(text.strip())
        if match is None or _OF_A_GEAR.isdisjoint(words_of(key)):
            continue
        turns = float(match.group(1)) / float(match.group(2) or 1.0)
        if turns > 0.0 and turns != 1.0:
            turns = max(turns, 1.0 / turns) if match.group(2) else turns
            ratios.append((f"{key} = {match.group()}", turns))
    motion = draft.signals.get("slip") or draft.signals.get("position")
    effort = draft.signals.get("effort")
    if len(ratios) != 1 or motion is None or effort is None:
        return
    if not motion.column or not effort.column:
        return
    said, ratio = ratios[0]
    sides = {each.signal: not DRIVES.isdisjoint(words_of(each.column)) for each in (motion, effort)}
    if sides[motion.signal] == sides["effort"]:
        return  # both in front of the gear, or both behind it
    chosen = motion if sides[motion.signal] else effort
    if draft.guessed(chosen.signal) is None:
        return
    label = shell_word(draft.table.label(chosen.column))
    factor = 1.0 / ratio if chosen is motion else ratio
    scale = shell_word(f"{chosen.signal}={factor:.10g}")
    doubt = f"in front of a gear, and the file says {said}"
    doubt += f": give --{chosen.signal} {label} alone if the numbers are of the same side"
    draft.doubt(chosen.signal, doubt, f"{label} --scale {scale}")


def offer_stated_scales(draft: Draft) -> None:
    """Offer the motor's current for an effort, and counts for a position, where the file states what they mean."""
    if "effort" in draft.questions and not draft.questions["effort"].option:
        currents = [
            column
            for column in draft.seen.without(draft.taken)
            if column.spoken.says(CURRENTS) and column.spoken.says(DRIVES)
        ]
        _offer(draft, "effort", "effort", currents, "A")
    if "slip" in draft.questions and not draft.questions["slip"].option:
        counted = [
            column
            for column in draft.seen.without(draft.taken)
            if column.spoken.says(_COUNTED) and not column.shape.constant
        ]
        _offer(draft, "slip", "position", counted, "count")


def _offer(draft: Draft, about: str, signal: str, columns: list[SeenColumn], sensor: str) -> None:
    """Answer the question about a signal by the one column that a stated scale is for."""
    scales = [each for each in scales_stated(draft, signal) if each.sensor == sensor]
    if len(columns) != 1 or len(scales) != 1:
        return
    column = columns[0]
    own = column.unit if column.unit in COUNTS else None
    scale = shell_word(f"{signal}={scales[0].over(own or sensor)}")
    option = f"--{signal} {shell_word(draft.table.label(column.name))} --scale {scale}"
    draft.questions[about] = replace(
        draft.questions[about].adding(f"; the file says {scales[0].said}"),
        remedy=f"If that is of {column.name}, give {option}",
        option=option,
    )


def fill_in_stated_scales(draft: Draft) -> None:
    """Put what the file states in the place of a scale's number that only the user could have said."""
    for about, question in [*draft.questions.items()]:
        place = _PLACE.search(question.remedy) or _PLACE.search(question.option)
        if place is None:
            continue
        signal = question.remedy.partition("=NUMBER")[0].rpartition('"')[2] or about
        made, sensor = place.groups()
        is_count = sensor in COUNTS or sensor in ("count", "tick")
        own = "count" if is_count else sensor
        fitting = [each for each in scales_stated(draft, signal) if each.is_over(own)]
        if len(fitting) != 1:
            continue
        filled = fitting[0].over(sensor)
        # What the file says that the sensor reads where its signal is zero, such as ``2.5 V``.
        zeros: list[str] = []
        for key, text in draft.table.metadata.items():
            match = _FIRST_QUANTITY.fullmatch(text.strip())
            if match is None or ZEROS.isdisjoint(words_of(split_label(key)[0])):
                continue
            unit = (match.group(2) or "").strip()
            are_units = bool(unit) and units.is_unit(unit) and units.is_unit(sensor)
            if are_units and units.fits(unit, (sensor,)):
                zeros.append(f"{match.group(1)} {unit}")
        zero = zeros[0] if len(zeros) == 1 else ""
        hole = f"NUMBER {made}/{sensor}"
        draft.questions[about] = replace(
            question.adding(f"; the file says {fitting[0].said}"),
            remedy=_filled(question.remedy, hole, filled, signal, zero),
            option=_filled(question.option, hole, filled, signal, zero),
        )
        draft.examples = [
            _filled(example, hole, filled, signal, zero) for example in draft.examples
        ]
    for signal, chosen in [*draft.signals.items()]:
        place = _PLACE.search(chosen.answer)
        fitting = [] if place is None else [*scales_stated(draft, signal)]
        fitting = [each for each in fitting if place and each.is_over(place[2])]
        if place is not None and len(fitting) == 1:
            answer = chosen.answer.replace(place[0], fitting[0].over(place[2]))
            draft.doubt(signal, f"{chosen.doubt}; the file says {fitting[0].said}", answer)


def _filled(text: str, hole: str, filled: str, signal: str, zero: str) -> str:
    """A text with a stated scale in the place of its hole, and behind the option the stated zero."""
    if not zero:
        return text.replace(hole, filled)
    option = f"--zero {shell_word(f'{signal}={zero}')}"
    return re.sub(rf"{re.escape(hole)}([\"']?)", lambda end: f"{filled}{end[1]} {option}", text)


def scales_stated(draft: Draft, signal: str) -> Iterator[StatedScale]:
    """The scales of a signal that the file states above its rows, each once."""
    seen: set[tuple[float, str]] = set()
    texts = dict(draft.table.metadata)
    # A number beside vectors has its unit in its name: LVDT_cal_mm_per_V.
    for key, value in draft.table.constants.items():
        of_unit = _PER.search(key)
        if of_unit is not None:
            texts[key] = f"{value!r} {of_unit[1]}/{of_unit[2]}"
    # The rated torque of a drive may have a column of its own, which never changes.
    for column in draft.seen.columns.values():
        unit = column.unit or column.spoken.end
        if unit and is_rating(column):
            texts[column.name] = f"{float(column.values[0])!r} {unit}"
    for key, text in texts.items():
        match = _FIRST_QUANTITY.match(text.strip())
        if match is None:
            continue
        number = float(match.group(1))
        unit = (match.group(2) or "").strip()
        said = f"{key} = {match.group().strip()}"
        stated: StatedScale | None = None
        if signal == "effort" and is_rated_torque(key):
            stated = _of_rated_torque(draft, said, number, unit)
        if signal in _MOTIONS:
            is_of_encoder = not _OF_AN_ENCODER.isdisjoint(words_of(split_label(key)[0]))
            # Of a pulse or a line that are counted; what is called counts has been counted.
            edges = 4 if _QUADRATURE.search(text) and not _COUNTED_ALREADY.match(unit) else 1
            is_bare = not _QUADRATURE.sub("", unit).strip()
            counts_turns = _OF_A_TURN.search(unit) or (is_bare and is_of_encoder)
            if counts_turns and number >= _FEWEST_COUNTS:
                stated = StatedScale(said, 2 * pi / (edges * number), "rad", "count")
        if stated is None and unit and not (signal == "effort" and is_rated_torque(key)):
            try:
                factor, made, sensor = scaled(f"{number:g} {unit}", signal)
            except (MappingError, UnitError):
                continue
            if made and sensor:
                stated = _of_signal(StatedScale(said, factor, made, sensor), signal)
        if stated is not None and (stated.number, stated.sensor) not in seen:
            seen.add((stated.number, stated.sensor))
            yield stated


def _of_rated_torque(draft: Draft, said: str, number: float, unit: str) -> StatedScale | None:
    """What a 1 is in the column that tells shares of a rated torque, which the file states; None for another unit.

    A torque in plain percent is one of them, where a rated torque stands above the rows.
    """
    fitting = units.fits(unit, ("N*m",)) if unit and units.is_unit(unit) else None
    if fitting is None:
        return None
    torque = number * fitting[0]  # N m
    for column in draft.seen.columns.values():
        share = share_of_rated_torque(column)
        if share is not None:
            return StatedScale(said, torque * share.size, "N*m", share.sensor)
    return StatedScale(said, torque / 100.0, "N*m", "%")


def _of_signal(stated: StatedScale, signal: str) -> StatedScale | None:
    """The scale if it may be that of a signal: 25 mm/V is of a position, whichever signal is asked about."""
    kinds = SIGNALS[signal].si_units
    if stated.sensor in COUNTS:
        return stated if units.fits(stated.made, kinds) else None
    # 2 mV/N is what a load cell gives for a force, and 100 mV/A a probe for a current.
    gives_a_voltage = units.fits(stated.made, ("V",)) and not units.fits(stated.sensor, ("V",))
    if gives_a_voltage and units.fits(stated.sensor, kinds):
        number = 1.0 / stated.number
        return (
            stated._replace(number=number, made=stated.sensor, sensor=stated.made)
            if isfinite(number)
            else None
        )
    return stated if units.fits(stated.made, kinds) else None
