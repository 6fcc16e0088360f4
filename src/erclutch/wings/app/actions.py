"""What a form asks for becomes the words of a command, and the same in Python."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlencode

from erclutch.errors import TYPED, UnitError
from erclutch.logs.mapping import NONE
from erclutch.runs.run_shape import reading_of
from erclutch.signals.speed import DERIVATIVES
from erclutch.signals.units import in_unit
from erclutch.wings.app.workspace import WorkspaceError, plain_name

#: Signals of each device that a form asks for, in its order.
ASKED: Mapping[str, tuple[str, ...]] = {
    "single": ("time", "field", "slip", "position", "effort", "temperature"),
    "coaxial": (
        "time",
        "E1",
        "E2",
        "E",
        "theta",
        "theta_dot",
        "alpha",
        "alpha_dot",
        "alpha_raw",
        "T",
        "temperature",
    ),
}
MEANING: Mapping[str, str] = {
    "time": "time stamps",
    "field": "command to the fluid: voltage, current or field strength",
    "slip": "relative speed across the fluid",
    "position": "relative position; differentiated where the slip is not logged",
    "effort": "measured torque or force",
    "temperature": "of the fluid",
    "E1": "field of clutch CH1",
    "E2": "field of clutch CH2",
    "E": "signed field E1 - E2, in place of both",
    "theta": "angle of the motor",
    "theta_dot": "speed of the motor",
    "alpha": "angle of the output",
    "alpha_dot": "speed of the output",
    "alpha_raw": "position of the table on the screw; needs a lead",
    "T": "torque of the pair",
}
#: Further texts of the reading that a form has: option, what it means, an example.
READING: tuple[tuple[str, str, str], ...] = (
    ("rate", "sampling rate in place of a time column", "1000 Hz"),
    ("lead", "travel of the table in one turn of the screw", "10 mm"),
    ("constant", "a signal that was constant; of several signals with ; between", "field=0.5 A"),
    ("scale", "what a sensor in volts means; of several with ; between", "effort=2.5 N*m/V"),
    ("zero", "what a column reads where its signal is zero; of several likewise", "effort=2048"),
    ("input", "a further column that networks take; several with ; between", "accel"),
    ("variable", "which recording of a file that holds several", "all"),
    ("from", "take the log from this time on", "2s"),
    ("until", "take it up to this time", "60s"),
    ("skip", "leave out so much at the start", "2s"),
    ("invalid", "what to do with missing values: error or drop", "drop"),
    ("name-pattern", "numbers in the name of the file", "test-{field}A"),
    ("decimal", "decimal mark of numbers that may be read in two ways", ","),
    ("keep-values", "keep values such as -999, which loggers write for no measurement", ""),
    ("resample", "bring the log to another sampling rate", "1 kHz"),
    ("derivative", "filter for speeds that are not logged", "savgol"),
    ("cutoff", "bandwidth of the filters lowpass and kalman in Hz", "150"),
    ("window", "rows of the filter savgol", "5"),
    ("map", "read it as this mapping file says, which another log may have", "LOG.csv.toml"),
)
#: Options of these that a command takes several times; a form has one line for them all, and this between.
_SEVERAL = ("constant", "scale", "zero", "input")
_BETWEEN = ";"
#: Options of these that have no value: a form has a box to tick.
SWITCHES = ("keep-values",)
#: What a form says of a fit: option, label, what it means, its default.
FITTING: tuple[tuple[str, str, str, str], ...] = (
    (
        "models",
        "More models",
        "names as in a ranking, with spaces between, also with other stages",
        "",
    ),
    (
        "lag",
        "Lags and memory",
        "auto: as far as the data ask for it; none; or stages joined by +",
        "auto",
    ),
    (
        "test",
        "Held out",
        "a share of the rows, at the end of the log; stretches; auto: 0.3, or stretches where the end goes beyond",
        "auto",
    ),
    ("seed", "Seed", "the same seed gives the same figures", "0"),
)
#: What every log has. Where its guess is taken back, the page asks for it.
_NEEDED = ("time", "effort", "T")
_FILTERS = "|".join(DERIVATIVES)
_OPTION = re.compile(
    rf"--([A-Za-z][\w-]*)(?:[ =](?=[\"'A-Z0-9]|(?:none|drop|all|{_FILTERS})\b|\S*[+/]))?"
)
_OPTION_AND_VALUE = re.compile(r"""(--[\w-]+) ('[^']*'|"[^"]*"|\S+)""")
_ALL_ASKED = re.compile(
    rf"Give them all, with your columns in place of these: ((?:{_OPTION_AND_VALUE.pattern} ?)+)"
)
#: Of exports in C: their controllers are most often without double.
SINGLE_TARGETS = ("c", "cpp")


def on_page(text: str) -> str:
    """A message of a command, with the names of the form's fields in place of options."""
    labels = {option: option for option, *_ in READING}
    labels |= {option: name for option, name, *_ in FITTING}
    for signals in ASKED.values():
        labels |= {signal.replace("_", "-"): signal for signal in signals}
    labels |= {"out": "Name of the run", "device": "Device"}

    def named(match: re.Match[str]) -> str:
        name = labels.get(match[1])
        if name is None:
            return match[0]
        has_value = match[0][-1] in " ="
        return f"“{name}”: " if has_value else f"“{name}”"

    def chosen_below(asked: re.Match[str]) -> str:
        """In place of an option for each open signal; an option with a hole stays to be chosen."""
        known = [
            f"{option} {value}"
            for option, value in _OPTION_AND_VALUE.findall(asked[1])
            if "COLUMN" not in value
        ]
        likely = f", such as {' '.join(known)}" if known else ""
        return f"Choose a column for each below{likely}; the foot of this page draws them"

    shorter = re.sub(r"erclutch (?:inspect|fit) (?:'[^']*'|\S+) (?=--)", "", text)
    shorter = _ALL_ASKED.sub(chosen_below, shorter)
    shorter = re.sub(r"(?<=[\"']) (?=--)", ", ", shorter)
    return re.sub(r"”: none\b", "”: not logged", _OPTION.sub(named, shorter))


@dataclass(frozen=True)
class Chosen:
    """How a log is to be read: the choices that somebody made, not the guesses.

    Attributes:
        device: "single" or "coaxial".
        columns: label of the column of a signal, such as "V [cm/s]" or "-F [N]".
        texts: further options by name.
    """

    device: str
    columns: Mapping[str, str]
    texts: Mapping[str, str]

    def words(self) -> list[str]:
        """Words of a command."""
        words = ["--device", self.device] if self.device != "single" else []
        for signal, label in self.columns.items():
            words += _option(signal.replace("_", "-"), label)
        for option, text in self.texts.items():
            if option in SWITCHES:
                words.append(f"--{option}")
                continue
            for each in _each(option, text):
                words += _option(option, each)
        return words

    def keywords(self) -> str:
        """Further arguments of `erclutch.read`, as Python writes them."""
        texts = dict(self.texts)
        columns: dict[str, Any] = dict(self.columns)
        plain = {key: texts.pop(key) for key in ("rate", "lead") if key in texts}
        pairs: dict[str, dict[str, str]] = {}
        for key in ("constant", "scale", "zero"):
            for each in _each(key, texts.pop(key, "")):
                name, _, text = each.partition("=")
                pairs.setdefault(f"{key}s", {})[name] = text

        # Where more than columns is told, the mapping has a table of its own for these.
        mapping: dict[str, Any] = columns
        if plain or pairs:
            time = {"time": columns.pop("time")} if "time" in columns else {}
            mapping = {"columns": columns, **plain, **pairs, **time}

        words = {
            "device": self.device if self.device != "single" else None,
            "variable": texts.get("variable"),
            "invalid": texts.get("invalid"),
            "input": _each("input", texts.get("input", "")) or None,
            "name_pattern": texts.get("name-pattern"),
            "decimal": texts.get("decimal"),
            "keep_values": True if "keep-values" in texts else None,
            "resample": texts.get("resample"),
            "mapping_file": texts.get("map"),
            "begin": texts.get("from"),
            "end": texts.get("until"),
            "skip": texts.get("skip"),
        }
        arguments = [f", {mapping!r}"] if mapping else []
        arguments += [f", {key}={value!r}" for key, value in words.items() if value is not None]
        return "".join(arguments)

    def derivative(self) -> str:
        """A further argument of `erclutch.build_dataset`, as Python writes it: the filter for speeds.

        A text that is no number stays a text: Python refuses it as the command does, and the page can be shown.
        """
        arguments: list[str] = []
        if "derivative" in self.texts:
            arguments.append(repr(self.texts["derivative"]))
        if "cutoff" in self.texts:
            cutoff: float | str = self.texts["cutoff"]
            with suppress(UnitError):
                cutoff = in_unit(cutoff, "Hz")
            arguments.append(f"cutoff={cutoff!r}")
        if "window" in self.texts:
            window = self.texts["window"]
            arguments.append(f"window={window if window.isdecimal() else repr(window)}")
        return f", derivative=erclutch.Derivative({', '.join(arguments)})" if arguments else ""


def chosen_of(form: Mapping[str, str]) -> Chosen:
    """The choices in a form: what differs from what the page showed as a guess, and what was chosen before.

    Raises:
        WorkspaceError: another device, or a text with control characters or more than 200 characters.
    """
    device = form.get("device", "single")
    if device not in ASKED:
        raise WorkspaceError(
            f"there is no device {device[:40]!r}", remedy=f"Choose {' or '.join(ASKED)}"
        )
    columns: dict[str, str] = {}
    for signal in ASKED[device]:
        column = form.get(f"column.{signal}", "")
        unit = form.get(f"unit.{signal}", "").strip()
        chosen = label(column, unit, f"turn.{signal}" in form)
        before = form.get(f"given.{signal}", "")
        if chosen != form.get(f"was.{signal}", ""):
            taken_back = "" if signal in _NEEDED else NONE
            before = chosen or taken_back
        if before:
            columns[signal] = _text(before)
    texts: dict[str, str] = {}
    for option, _, _ in READING:
        given = form.get(option, "")
        if given.strip():
            texts[option] = _text(given)
    if "map" in texts:
        plain_name(texts["map"])  # of the workspace
    return Chosen(device, columns, texts)


#: What a run calls options of the command line.
_IN_PYTHON = {typed: name for name, typed in TYPED.items()}
#: A window in time belongs to the log that it was given for.
_OF_ONE_LOG = ("from", "until", "skip")


def query_of(run: Mapping[str, Any], *, of_another_log: bool = False) -> str:
    """How a run read its logs, as the query of a log's page; `chosen_of` reads it. Another log is taken whole."""
    reading = reading_of(run)
    device = str(run["device"])
    form = {f"given.{signal}": reading.get(signal.lower()) for signal in ASKED.get(device, ())}
    for option, _, _ in READING:
        # The mapping may have changed since.
        if option == "map" or (of_another_log and option in _OF_ONE_LOG):
            continue
        value = reading.get(_IN_PYTHON.get(option, option.replace("-", "_")), "")
        form[option] = "on" if option in SWITCHES and value else value
        if option in _SEVERAL:
            form[option] = f"{_BETWEEN} ".join(value)
    filled_in = {key: str(value) for key, value in form.items() if value}
    return urlencode({"device": device, **filled_in})


def _each(option: str, text: str) -> list[str]:
    """The values of an option in a line of a form: one, or of some options several."""
    if option not in _SEVERAL:
        return [text]
    return [each.strip() for each in text.split(_BETWEEN) if each.strip()]


def _option(name: str, text: str) -> list[str]:
    """An option whose text may look like another option."""
    return [f"--{name}={text}"] if text.startswith("-") else [f"--{name}", text]


def label(column: str, unit: str, turned: bool) -> str:
    """How a command names a column: "-NAME [unit]" with its sign turned."""
    if not column:
        return ""
    sign = "-" if turned else ""
    return f"{sign}{column} [{unit}]" if unit else f"{sign}{column}"


def _text(text: str) -> str:
    if not text.isprintable() or len(text) > 200:
        raise WorkspaceError(
            f"{text[:40]!r} is too long or has control characters", remedy="Write a short text"
        )
    return text.strip()


#: What may be said of a log or a run: field of `RunAbout`, label, an example.
SAID: tuple[tuple[str, str, str], ...] = (
    ("device", "Device", "MR brake 7"),
    ("author", "Who measured", "A. Smith"),
    ("date", "Day", "2026-07-31"),
    ("tags", "Tags", "winter, new oil"),
    ("note", "Note", "after the repair of the seal"),
)


def fit_words(
    form: Mapping[str, str],
    logs: Sequence[str],
    run: str,
) -> list[str]:
    """`erclutch fit` as a form asks for it."""
    words = ["fit", *map(plain_name, logs), *chosen_of(form).words()]
    models = _models(form)
    if models != ["all"]:
        words += ["--models", *models]
    for option, _, _, usual in FITTING[1:]:
        text = _text(form.get(option, "")) or usual
        if text != usual:
            words += _option(option, text)
    return [*words, "--out", run]


def _models(form: Mapping[str, str]) -> list[str]:
    ticked = [_text(name.removeprefix("model.")) for name in form if name.startswith("model.")]
    models = [*ticked, *_text(form.get("models", "")).split()] or ["all"]
    if any(model.startswith("-") for model in models):
        raise WorkspaceError(
            f"{' '.join(models)[:40]!r} are no models", remedy="See erclutch laws for their names"
        )
    return models


def fit_in_python(form: Mapping[str, str], logs: Sequence[str], run: str) -> str:
    """The same in Python."""
    from erclutch.logs.held_out import held_out_as_told

    chosen = chosen_of(form)
    models = _models(form)
    lag = _text(form.get("lag", ""))
    settings: list[str] = []
    if models != ["all"]:
        settings.append(f"models={tuple(models)!r}")
    if lag not in ("", "auto"):
        settings.append(f"lag={lag!r}")
    usual = {option: default for option, _, _, default in FITTING}
    test = _text(form.get("test", "")) or usual["test"]
    if test != usual["test"]:
        settings.append(f"test={held_out_as_told((test,))!r}")
    seed = _text(form.get("seed", "")) or usual["seed"]
    if seed != usual["seed"]:
        settings.append(f"seed={seed}")
    device = f", device={chosen.device!r}" if chosen.device != "single" else ""
    dataset = f"erclutch.build_dataset(logs{device}{chosen.derivative()})"
    reads = [f"    erclutch.read({name!r}{chosen.keywords()})," for name in logs]
    lines = [
        "import erclutch",
        "",
        "logs = [",
        *reads,
        "]",
        f"comparison = erclutch.compare({dataset}, erclutch.Settings({', '.join(settings)}))",
        f"erclutch.write_run({run!r}, comparison, logs)",
    ]
    return "\n".join(lines) + "\n"


def shown(words: Sequence[str]) -> str:
    """A command line to copy."""
    return shlex.join(["erclutch", *words])


def safe_stem(text: str) -> str:
    """A text as part of a file's name."""
    return re.sub(r"[^\w.-]+", "-", text)[:60].strip("-.") or "result"
