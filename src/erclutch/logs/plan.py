"""A plan says how the columns of a table become a recording: every choice, made before any of them is carried out.

A reader gives a `Table`; `erclutch.logs.planning.whole_plan.plan_of` weighs what the user said, what the file says and
how the columns are called, and makes the plan; `erclutch.logs.applied.apply` carries it out and decides nothing. A plan
can be printed, saved as a mapping file (`erclutch.logs.saved_plan`), loaded with the table that it is for, and
compared with another.
"""

from __future__ import annotations

import shlex
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Literal

from erclutch.errors import MappingError, SeveralColumnsError, listed, placed, shell_word
from erclutch.logs.mapping import ColumnChoice, ColumnMap
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import NAMED_COLUMNS, NO_FIELD

Invalid = Literal["error", "drop"]
#: How sure a choice is: the user gave it; name and unit agree; only one of them speaks; or little speaks for it.
Sureness = Literal["given", "sure", "likely", "doubtful"]
#: How a note goes on where what was given differs from what the file says; the check before a fit warns of it.
THOUGH = "though the file says"

#: Why an effort is in doubt whose slip is that of a joint among several.
OF_THE_SAME_JOINT = "of the same joint"

#: What stands behind the problem of a question, before all columns.
_THE_FILE_HAS = "; the file has: "

#: What a device needs: each group is satisfied by one of its alternatives, each of which is a set of signals.
NEEDS: Mapping[str, tuple[tuple[tuple[str, ...], ...], ...]] = {
    "single": ((("field",),), (("slip",), ("position",)), (("effort",),)),
    "coaxial": (
        (("E1", "E2"), ("E",)),
        (("theta_dot",), ("theta",)),
        (("alpha_dot",), ("alpha",), ("alpha_raw",)),
        (("T",),),
    ),
}
#: What a device may have besides; taken by its name where it is there.
OPTIONAL: Mapping[str, tuple[str, ...]] = {"single": (), "coaxial": ("motor_torque",)}


@dataclass(frozen=True)
class SignalPlan:
    """One signal: the column that it is read from, or the numbers that stand in place of a column.

    Attributes:
        signal: its name; of a further input, the name that it travels under.
        column: name in the table; "" where numbers take its place.
        unit: of the column; None where nobody says it.
        scale: before the unit is converted; -1 turns the sign.
        factor: from the column's numbers to the unit of the recording, scale and sensor included.
        si: unit of the recording, for a further input that of its column; "" is dimensionless, "?" unknown.
        numbers: in the unit of the recording, one for the whole log or one for each segment; () where a column is read.
        lead: of the screw in m, where the column is the position on a screw and the signal an angle; else None.
        offset: added behind the factor, in the unit of the recording: 273.15 K for a temperature in °C, and minus the
            zero of a sensor.
        reason: who chose it, or what it was guessed from.
        sureness: how sure the choice is.
        doubt: why it is doubtful; "" where its unit alone speaks for it, and its numbers do not.
        answer: what the printed command says of a doubtful signal in place of its column.
        alternatives: other columns that would do.
    """

    signal: str
    column: str = ""
    unit: str | None = None
    scale: float = 1.0
    factor: float = 1.0
    si: str = "?"
    numbers: tuple[float, ...] = ()
    lead: float | None = None
    offset: float = 0.0
    reason: str = field(default="given", compare=False)
    sureness: Sureness = field(default="given", compare=False)
    doubt: str = field(default="", compare=False)
    answer: str = field(default="", compare=False)
    alternatives: tuple[str, ...] = field(default=(), compare=False)


@dataclass(frozen=True)
class ClockPlan:
    """The clock that rows are put on.

    Attributes:
        kind: "rate" counts rows; "column" reads stamps; "dates" takes the table's dates; "counter" counts samples by a
            column; "header" counts rows by the period that the file states; "points" are rows in no time.
        column: of stamps, dates or a counter.
        unit: of the stamps as written; None where nobody says it.
        scale: before the unit is converted.
        factor: from stamps to s, scale included.
        zero: stamp that is 0 s, in the column's unit.
        period: in s: of "rate", "counter" and "header"; of stamps what the header states, taken where they agree.
        not_signals: columns that tell the time or count samples; rows are compared without them.
        is_mixed_up: whether the rows stand in no order of their stamps, and are sorted by them.
        reason: who chose it, or what it was guessed from.
        sentence: what the time is taken from, for the notes of a recording.
        doubt: why stamps without a unit may be no seconds, one sentence; "" for no doubt.
        likely: the unit that is proposed where there is a doubt; "" where stamps count the rows: a rate is asked for.
    """

    kind: Literal["rate", "column", "dates", "counter", "header", "points"]
    column: str = ""
    unit: str | None = None
    scale: float = 1.0
    factor: float = 1.0
    zero: float = 0.0
    period: float | None = None
    not_signals: tuple[str, ...] = ()
    is_mixed_up: bool = False
    reason: str = field(default="given", compare=False)
    sentence: str = field(default="", compare=False)
    doubt: str = field(default="", compare=False)
    likely: str = field(default="s", compare=False)


@dataclass(frozen=True)
class Joint:
    """A joint of a log of several: a device of its own.

    Attributes:
        name: what its columns have in their names and those of other joints have not: "joint 2", "waist".
        slip: column of its speed.
        effort: column of its effort.
    """

    name: str
    slip: str
    effort: str


@dataclass(frozen=True)
class Question:
    """What the plan cannot say, and only the user can.

    Attributes:
        signal: the signal, ``time``, ``lead`` or ``input`` that it is about.
        problem: what is missing, or what cannot be told.
        remedy: an option that answers it.
        kind: of the error that asks it.
        option: that option alone, ready to be typed, where it is known.
        answers: of the error, see `ErclutchError`; a step of the plan may know a better option.
        file_option: of the error, see ``option`` of `ErclutchError`.
    """

    signal: str
    problem: str
    remedy: str
    kind: type[MappingError] = MappingError
    option: str = ""
    answers: tuple[str, ...] = ()
    file_option: str = ""

    @property
    def short(self) -> str:
        """The problem without the list of all columns."""
        return self.problem.partition(_THE_FILE_HAS)[0]

    def adding(self, more: str) -> Question:
        """The question with more behind its problem, in front of the list of all columns."""
        problem, listed, columns = self.problem.partition(_THE_FILE_HAS)
        return replace(self, problem=f"{problem}{more}{listed}{columns}")

    def error(self) -> MappingError:
        """The question as an error, for whom only an answer helps."""
        return self.kind(
            self.problem, remedy=self.remedy, answers=self.answers, option=self.file_option
        )


@dataclass(frozen=True)
class Plan:
    """How a table becomes a recording.

    Two plans are equal where they make the same recording of a table, whoever chose what.

    Attributes:
        log: name of the log that it was made for.
        device: what the signals belong to.
        signals: in the order in which they were chosen; the temperature is one of them.
        clock: None while a question is open about it.
        inputs: further inputs of networks, as logged.
        spare: further columns that are worth a look.
        constants: numbers that hold for the whole log.
        invalid: what is done about values that are not finite.
        questions: what only the user can say; such a plan cannot be applied.
        labels: the table's columns as a user would write them.
        told: the answers that the plan is made from: the user's, and those of a mapping file.
        notes: what was chosen, guessed, converted and assumed, one sentence each.
        path: of the file, for the command that answers all questions.
        examples: options that answer the questions, in their order.
        joints: of a log of several, each of which is a device; the signals are those of one of them.
    """

    log: str = field(compare=False)
    device: DeviceName
    signals: tuple[SignalPlan, ...]
    clock: ClockPlan | None
    inputs: tuple[SignalPlan, ...] = ()
    spare: tuple[str, ...] = ()
    constants: Mapping[str, float] = field(default_factory=dict[str, float])
    invalid: Invalid = "error"
    questions: tuple[Question, ...] = ()
    labels: Mapping[str, str] = field(default_factory=dict[str, str], compare=False)
    told: ColumnMap = field(default_factory=ColumnMap, compare=False)
    notes: tuple[str, ...] = field(default=(), compare=False)
    path: str = field(default="", compare=False)
    examples: tuple[str, ...] = field(default=(), compare=False)
    joints: tuple[Joint, ...] = field(default=(), compare=False)

    def __str__(self) -> str:
        """The plan as a person reads it: each choice and each question on a line."""
        lines = [*self.notes]
        if self.clock is not None:
            lines.append(self.clock.sentence)
        lines += [f"question: {question.short}" for question in self.questions]
        return "\n".join(lines)

    def signal(self, name: str) -> SignalPlan | None:
        """The choice for a signal, or None."""
        return next((each for each in self.signals if each.signal == name), None)

    @property
    def sure_field(self) -> str:
        """The column that is the field without much doubt; "" for none."""
        field = self.signal("field")
        return "" if field is None or field.sureness == "doubtful" else field.column

    @property
    def signals_with_columns(self) -> set[str]:
        """Names of the signals that are read from a column."""
        return {each.signal for each in self.signals if each.column}

    @property
    def choices(self) -> dict[str, ColumnChoice]:
        """The column of each signal, and of the time."""
        choices: dict[str, ColumnChoice] = {}
        for each in self.signals:
            if each.column:
                choices[each.signal] = ColumnChoice(each.column, each.unit, each.scale, each.reason)
        clock = self.clock
        if clock is not None and clock.kind == "column":
            choices["time"] = ColumnChoice(clock.column, clock.unit, clock.scale, clock.reason)
        return choices

    @property
    def doubts(self) -> tuple[str, ...]:
        """What is guessed on little ground, one sentence each; the user says whether it is right."""
        doubts: list[str] = []
        for each in self.signals:
            if each.sureness == "doubtful":
                others = ""
                if each.alternatives:
                    others = f"; {', '.join(each.alternatives)} may be it too"
                why = each.doubt or "by its unit alone, and its numbers do not look like that"
                is_it = "may be" if each.answer else "is"
                doubts.append(f"{each.signal} {is_it} column {each.column} {why}{others}")
        if self.clock is not None and self.clock.doubt:
            doubts.append(self.clock.doubt)
        return tuple(doubts)

    @property
    def leaves_open_which_joint(self) -> bool:
        """Whether the joint is all that the user has to choose; nothing else is asked or in doubt."""
        if not self.joints or self.questions or (self.clock is not None and self.clock.doubt):
            return False
        doubts = {each.signal: each.doubt for each in self.signals if each.sureness == "doubtful"}
        of_joints = {"slip": of_one_joint(self.joints, self.labels), "effort": OF_THE_SAME_JOINT}
        return doubts == of_joints

    @property
    def is_of_a_log(self) -> bool:
        """Whether all but the field was found, or is one of several columns: a table without a motion is no log."""
        return self._has_all_but("field")

    @property
    def has_motion(self) -> bool:
        """Whether all but the field and the effort was found, or is one of several columns."""
        return self._has_all_but("field", "effort", "T")

    @property
    def signals_in_sight(self) -> set[str]:
        """Names of the signals that are read from a column, or may be read from any of several."""
        in_question = {each.signal for each in self.questions if each.kind is SeveralColumnsError}
        return self.signals_with_columns | in_question

    def _has_all_but(self, *spared: str) -> bool:
        """Whether each signal that the device needs was found, but for those spared."""
        known = self.signals_in_sight
        for group in NEEDS[self.device]:
            is_spared = any((signal,) in group for signal in spared)
            is_met = any(not known.isdisjoint(option) for option in group)
            if not is_spared and not is_met:
                return False
        return True

    def require_sureness(self) -> None:
        """Refuse a plan with open questions, or one that rests on a guess of little ground.

        Raises:
            MappingError: what is missing, see `require_answers`; or what is in doubt, with the options that settle it.
        """
        with placed(self.log):
            self.require_answers()
        if self.doubts:
            remedy = f"If that is right, say so: {' '.join(self._doubtful_options('s'))}"
            if self.clock is not None and self.clock.doubt:
                small = self.clock.likely if self.clock.likely in ("us", "ns", "d") else "ms"
                in_small = shell_word(f"{self.clock.column} [{small}]")
                remedy += f", or --time {in_small}, or give --rate"
            if self.leaves_open_which_joint and self.path:
                each = f"erclutch fit-many {shlex.quote(self.path)} --by joint --out RUNS"
                remedy += f". Each joint by itself: {each}"
            raise MappingError("; ".join(self.doubts), remedy=remedy, where=self.log)

    def _doubtful_options(self, unit: str = "") -> list[str]:
        """Options for what is in doubt; of the time with this unit, or with the likely one."""
        doubtful = [each for each in self.signals if each.sureness == "doubtful"]
        options: list[str] = []
        for each in doubtful:
            answer = each.answer or shell_word(self.labels[each.column])
            options.append(f"--{each.signal} {answer}")
        if self.clock is not None and self.clock.doubt:
            likely = unit or self.clock.likely
            if likely:
                options.append(f"--time {shell_word(f'{self.clock.column} [{likely}]')}")
            else:
                options.append('--rate "RATE Hz"')
        # With one joint given, the columns of the others may be the field again.
        field = self.signal("field")
        if self.joints and field is not None and field.reason == NO_FIELD:
            options.insert(0, "--field none")
        return options

    def _given_options(self, asked: Container[str]) -> list[str]:
        """What the user gave, as options of a command; none for signals that are asked about."""
        told = self.told
        choices = {**told.columns, **({"time": told.time} if told.time else {})}
        words: list[str] = []
        for name, choice in choices.items():
            if choice.source == "given" and name not in asked:
                label = f"{choice.column} [{choice.unit}]" if choice.unit else f"{choice.column}"
                words.append(f"--{name} {shell_word(label)}")
        if self.device != "single":
            words.append(f"--device {self.device}")
        if told.source != "given":
            return words
        if told.rate is not None:
            words.append(f"--rate {told.rate:g}")
        if told.lead is not None:
            words.append(f'--lead "{told.lead:g} m"')
        for name, text in told.constants.items():
            words.append(f"--constant {shell_word(f'{name}={text}')}")
        for name, text in told.scales.items():
            if name not in asked:
                words.append(f"--scale {shell_word(f'{name}={text}')}")
        for name, text in told.zeros.items():
            words.append(f"--zero {shell_word(f'{name}={text}')}")
        return words

    def _reading_options(self, beside: Sequence[str]) -> list[str]:
        """How the user said that the file is read, as options; none of what stands ``beside`` them already."""
        told = self.told
        if told.source != "given":
            return []
        words = [f"--input {shell_word(str(choice.column))}" for choice in told.inputs]
        words += ["--keep-values"] if told.values == "keep" else []
        for key in ("name_pattern", "variable", "decimal", "invalid"):
            option = f"--{key.replace('_', '-')}"
            if getattr(told, key) and not any(each.startswith(f"{option} ") for each in beside):
                words.append(f"{option} {shell_word(getattr(told, key))}")
        return words

    def command(self) -> str:
        """The command by which the user answers the questions, and says all that is guessed on little ground.

        Where nothing tells, it has a place to fill in, such as ``COLUMN [N]``.
        """
        asked = {question.signal for question in self.questions}
        options = [*self._given_options(asked), *self.examples, *self._doubtful_options()]
        options += self._reading_options(options)
        return f"erclutch inspect {shlex.quote(self.path)} {' '.join(options)}"

    def differences(self, other: Plan) -> tuple[str, ...]:
        """What another plan does differently, one sentence each; none where the plans are equal."""
        differences: list[str] = []
        for each in fields(self):
            here = getattr(self, each.name)
            there = getattr(other, each.name)
            if each.compare and here != there:
                differences.append(f"{each.name}: {here} here, {there} there")
        return tuple(differences)

    def require_answers(self) -> None:
        """Refuse a plan with open questions.

        Raises:
            MappingError: what is missing, with one command that answers all of it once it is filled in. UnitError: of
                one question that is about a unit.
        """
        if not self.questions:
            return
        if len(self.questions) == 1:
            raise self.questions[0].error()
        missing = [f"({place}) {each.short}" for place, each in enumerate(self.questions, start=1)]
        has = f"the file has: {listed(self.labels.values())}"
        problem = f"{len(missing)} things are missing: {'; '.join(missing)}; {has}"

        asked = {question.signal for question in self.questions}
        options = [*self._given_options(asked), *self.examples]
        options += self._reading_options(options) if self.path else []
        command = f"erclutch inspect {shlex.quote(self.path)} {' '.join(options)}"
        if not self.path:
            # Of a DataFrame or of arrays: labels as `erclutch.read` takes them.
            words = shlex.split(" ".join(options))
            values: dict[str, str] = {}
            for option, value in zip(words[::2], words[1::2], strict=True):
                values[option.removeprefix("--")] = value
            named = (*NAMED_COLUMNS, "time")
            command = str({name: label for name, label in values.items() if name in named})
            if "scale" in values:  # what a volt or a count of the sensor is
                command += f" with --scale {shell_word(values['scale'])}"

        remedy = f"Give them all, with your columns in place of these: {command}"
        field_remedy = next((each.remedy for each in self.questions if each.signal == "field"), "")
        if "--field none" in field_remedy and "--field none" not in " ".join(options):
            remedy += "; --field none if it was not logged"
        hints = [each.remedy.partition("; if ")[2] for each in self.questions]
        of_a_pair = next(filter(None, hints), "")
        if of_a_pair:
            remedy += f"; if {of_a_pair}"
        of_files = {each.file_option for each in self.questions}
        of_a_file = [
            each for each in self.examples if each in of_files or each.startswith("--name-pattern ")
        ]
        raise MappingError(problem, remedy=remedy, option=next(iter(of_a_file), ""))


def of_one_joint(joints: Sequence[Joint], labels: Mapping[str, str]) -> str:
    """Why the slip is in doubt that is the first joint's of several, with the options that take another joint."""
    _, other, *_ = joints
    slip = shell_word(labels.get(other.slip, other.slip))
    effort = shell_word(labels.get(other.effort, other.effort))
    option = f"--slip {slip} --effort {effort}"
    return f"of one of {len(joints)} joints, each a device of its own; another is {option}"
