"""Commands that follow from a public function: its parameters become arguments and options.

What a signature and a docstring cannot say (another spelling, a metavar, how text becomes a value) is in
``Option``; everything else is declared once, by the function.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from autobalance.command import options
from autobalance.command.console import add_objects
from autobalance.command.help_groups import most_used_first
from autobalance.command.options import add_json
from autobalance.verbs.declaration import REQUIRED, Parameter, parameters_of

Keywords = dict[str, Any]


NEGATIVE = re.compile(r"^-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?(,.*)?$")
"""Before Python 3.14 argparse takes -3e-7 for an option, and always -3,0,7."""


class Option(NamedTuple):
    """Spelling and reading of a parameter, where they do not follow from its declaration.

    Attributes
    ----------
    flags : tuple of str
        Spellings; empty: ``--`` and the parameter's name.
    metavar : str, tuple of str or None
    positional : bool
        An argument without a dash, though it has a default.
    normal : callable or None
        Text → the value or the choice that is meant.
    nargs : int or str or None
        Number of words.
    read : callable or None
        (option as typed, text or texts) → value of the parameter.
    repeated : bool
        Whether the option may be given several times.
    choices : tuple of str
        What may be typed, where the program has a table of it.
    value : bool or None
        Value of an option without words, where it is not the opposite of its default.
    required : bool
        An option that must be given, though the parameter has a default.
    usual : str
        The default in words, where the command has its own.
    alone : str or None
        What the option stands for without a value; None: it needs one.
    unset : bool
        Leave the option None where it is not typed, in place of the parameter's default.
    endings : callable or None
        Gives the endings of the files that may be typed.
    """

    flags: tuple[str, ...] = ()
    metavar: str | tuple[str, ...] | None = None
    positional: bool = False
    normal: Callable[[str], object] | None = None
    nargs: int | str | None = None
    read: Callable[[str, Any], Any] | None = None
    repeated: bool = False
    choices: tuple[str, ...] = ()
    value: bool | None = None
    required: bool = False
    usual: str = ""
    alone: str | None = None
    unset: bool = False
    endings: Callable[[], tuple[str, ...]] | None = None


UNIT = Option(normal=options.length_unit)
COMMON: Mapping[str, Option] = {
    "cluster": Option(metavar="tcp://HOST:PORT"),
    "cluster_timeout_s": Option(("--cluster-timeout",), metavar="S"),
    "reference_z_mm": Option(("--reference-z",), metavar="MM"),
    "settings": Option(("--set",), metavar="KEY=VALUE", read=options.settings, repeated=True),
    "unit": UNIT,
}
"""Parameters that have the same form in every command."""
SUGGEST_OPTION = Option(metavar="KEY=VALUE", read=options.wanted, repeated=True, alone="")
EXCLUSIVE_OPTIONS = (("workers", "cluster"),)
READERS: Mapping[str, Callable[[str, Any], Any]] = {
    "Sequence[float]": options.numbers,
    "tuple[float, float]": options.number_pair,
    "tuple[str, str]": options.word_pair,
    "Mapping[str, float]": options.number_table,
}
"""Type of a parameter → how its text is read."""
NUMBERS: Mapping[str, type] = {"int": int, "float": float}
UNITS = {"rpm": "RPM", "mm": "MM", "kg_m3": "KG/M3", "gpa": "GPA", "s": "S", "mb": "MB"}
"""End of a parameter's name → what stands for its value in the help."""
NAMES = ("Poisson", "Dask")
"""Words that keep their capital."""
OF_PYTHON = ("Crank", "Progress", "Callable[", "TableOptions")
"""Parameters of these types are objects of Python, which nobody can type."""
OPTIONS_OF_CRANK = "verbs.crank_job:options_of_crank"
OF_CRANK: Mapping[str, Option] = {
    "unit": UNIT,
    "density_kg_m3": Option(metavar="KG/M3"),
    "material": Option(metavar="NAME"),
    "rotating_g": Option(metavar="W"),
    "reciprocating_g": Option(metavar="W"),
    "crankpin_g": Option(metavar="W"),
    "stroke_mm": Option(metavar="MM"),
    "rod_length_mm": Option(metavar="MM"),
    "factor": Option(metavar="F"),
    "grade": Option(metavar="G"),
    "speed_rpm": Option(metavar="RPM"),
    "method": Option(metavar="M,M,..."),
}
"""Options that stand for keys of a job, of verbs that take a crank's file in its place."""
NOT_TYPED = Option()
"""Stands for a parameter that is for Python alone, though it could be typed."""


class Verb(NamedTuple):
    """A command that calls one public function and prints its result.

    Attributes
    ----------
    function : str
        As ``"signals.verb:orders"``.
    examples : tuple of str
        Lines at the end of ``--help``.
    options : mapping
        By parameter.
    writes : tuple of callable
        Options for results: each is called with the parser.
    adjust : callable or None
        Called with the keywords of the function and the arguments before the function is called: refuses what
        does not go together, and adds what follows from the rest.
    series : callable or None
        Result → bytes of the file that ``--series`` asks for.
    outputs : tuple of str
        Parameters that are paths of files to write: they are not among those read.
    notes : callable or None
        Last lines of ``--help``.
    also : tuple of str
        Other functions, whose parameters this one takes as ``**keywords``.
    of_crank : bool
        Whether a crank's file may replace the job, with options for the job's keys.
    most_used : tuple of str
        Destinations of the options that ``--help`` lists first; empty: it lists all in one.
    runs : callable or None
        Takes the arguments and returns the exit code, in place of ``call``.
    """

    function: str
    examples: tuple[str, ...] = ()
    options: Mapping[str, Option] = {}
    writes: tuple[Callable[[argparse.ArgumentParser], None], ...] = (add_json,)
    adjust: Callable[[Keywords, argparse.Namespace], None] | None = None
    series: Callable[[Any], bytes] | None = None
    outputs: tuple[str, ...] = ()
    notes: Callable[[], str] | None = None
    also: tuple[str, ...] = ()
    of_crank: bool = False
    most_used: tuple[str, ...] = ()
    runs: Callable[[argparse.Namespace], int] | None = None

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        lines = ["examples:", *(f"  {line}" for line in self.examples)] if self.examples else []
        parser.epilog = "\n".join(lines + ([] if self.notes is None else [self.notes()]))
        declared = self._typed()
        groups: dict[str, argparse._ActionsContainer] = {}
        for together in EXCLUSIVE_OPTIONS:
            if all(name in declared for name in together):
                groups.update(dict.fromkeys(together, parser.add_mutually_exclusive_group()))
        of_crank = self._of_crank_alone()
        if of_crank:
            group = parser.add_argument_group("with a crank file in place of a job")
            groups.update(dict.fromkeys(of_crank, group))
        for parameter, option in declared.values():
            add_option(groups.get(parameter.name, parser), parameter, option)
        for add in self.writes:
            add(parser)
        if "progress" in parameters_of(self.function):
            add_objects(parser)
        most_used_first(parser, self.most_used)

    def run(self, arguments: argparse.Namespace) -> int:
        return (self.runs or self.call)(arguments)

    def call(self, arguments: argparse.Namespace) -> int:
        """Call the function, write and print its result; return the exit code."""
        from importlib import import_module

        from autobalance.command.console import shown
        from autobalance.command.finish import finish

        keywords = self.keywords(arguments)
        module, name = self.function.split(":")
        function = getattr(import_module(f"autobalance.{module}"), name)
        takes_progress = "progress" in parameters_of(self.function)
        with shown() as progress:
            result = function(**keywords, **({"progress": progress} if takes_progress else {}))
        files = self.job_file(keywords)
        if self.series is not None and arguments.series is not None:
            files[Path(arguments.series)] = self.series(result)
        return finish(arguments, result, self.sources(arguments), files)

    def keywords(self, arguments: argparse.Namespace) -> Keywords:
        """Return the function's keywords as they were typed."""
        keywords: Keywords = {}
        for name, (parameter, option) in self._typed().items():
            value = getattr(arguments, name)
            read = option.read or READERS.get(parameter.type)
            if read is not None and option.nargs is None and isinstance(value, str | list):
                value = read(flag_of(parameter, option), value)
            keywords[name] = value
        if self.adjust is not None:
            self.adjust(keywords, arguments)
        if self.of_crank:
            return self._with_job(keywords, arguments)
        if self._reads_a_job():
            from autobalance.job import load
            from autobalance.verbs.crank_job import OPEN

            may_lack = OPEN.get(self.function.partition(":")[2], ())
            keywords["job"] = load(keywords["job"], keywords.pop("settings"), may_lack)
        return keywords

    def _with_job(self, keywords: Keywords, arguments: argparse.Namespace) -> Keywords:
        """Return the keywords with the job that was named, or that options on a crank's file stand for."""
        from autobalance.job.from_options import refuse_beside_job
        from autobalance.verbs.crank_job import is_crank, job_given

        own, source = parameters_of(self.function), keywords["job"]
        options = {name: keywords[name] for name in parameters_of(OPTIONS_OF_CRANK)}
        tell_commas(options)
        if not is_crank(source):
            options = {name: value for name, value in options.items() if name not in own}
        keywords = {name: value for name, value in keywords.items() if name in own or name not in options}
        settings, name = keywords.pop("settings"), self.function.partition(":")[2]
        folder = getattr(arguments, "output", None)
        if str(source).endswith(".json") and not self._reads_a_job():  # a report, of a verb that takes one
            refuse_beside_job(options, source)
            return {**keywords, "settings": settings}
        at_speed = keywords.get("speed_rpm") is not None
        more_open = ("balance.speed_rpm",) if at_speed else ()
        return {**keywords, "job": job_given(name, source, options, settings, folder, more_open)}

    def job_file(self, keywords: Keywords) -> dict[Path, bytes]:
        """Return the job file that the options stand for, if it does not exist yet."""
        if not self.of_crank:
            return {}
        from autobalance.job import Job
        from autobalance.verbs.crank_job import new_job_file

        return new_job_file(keywords["job"]) if isinstance(keywords["job"], Job) else {}

    def flag(self, name: str) -> str:
        """Return the spelling of a parameter's option."""
        return flag_of(*self._typed()[name])

    def sources(self, arguments: argparse.Namespace) -> tuple[str, ...]:
        """Return the paths that are read."""
        typed = {name: parameter for name, (parameter, _) in self._typed().items()}
        paths = [name for name, each in typed.items() if "Path" in each.type or each.type == "JobSource"]
        paths_given = [getattr(arguments, name) for name in paths if name not in self.outputs]
        return tuple(path for path in paths_given if path is not None)

    def _typed(self) -> dict[str, tuple[Parameter, Option]]:
        """Return the parameters that can be typed, with how."""
        declared = dict(parameters_of(self.function))
        for other in self.also:
            declared = {**parameters_of(other), **declared}
        if self._reads_a_job():
            declared["settings"] = SETTINGS
        if self.of_crank:
            declared |= {name: parameters_of(OPTIONS_OF_CRANK)[name] for name in self._of_crank_alone()}
        usual = {**COMMON, **OF_CRANK} if self.of_crank or OPTIONS_OF_CRANK in self.also else COMMON
        return {
            name: (each, self.options.get(name) or usual.get(name) or Option())
            for name, each in declared.items()
            if self.options.get(name) is not NOT_TYPED
            and (each.default is REQUIRED or not each.type.startswith(OF_PYTHON))
        }

    def _of_crank_alone(self) -> list[str]:
        """Return the parameters that go with a crank's file alone."""
        if not self.of_crank and OPTIONS_OF_CRANK not in self.also:
            return []
        others = [each for each in self.also if each != OPTIONS_OF_CRANK]
        own = {name for each in (self.function, *others) for name in parameters_of(each)}
        return [name for name in parameters_of(OPTIONS_OF_CRANK) if name not in own]

    def _reads_a_job(self) -> bool:
        declared = parameters_of(self.function).get("job")
        return declared is not None and declared.type == "JobSource"


def tell_commas(options: Mapping[str, Any]) -> None:
    """Warn of numbers that were typed with a decimal comma, and how they are read."""
    from autobalance.command.console import warn
    from autobalance.job.from_options import flag, with_decimal_point

    for name, value in options.items():
        if isinstance(value, str) and name not in ("method", "unit", "material"):
            point = with_decimal_point(value, flag(name))
            if point != value:
                warn(f"{flag(name)} {value} is read as {point}: the comma is a decimal point")


def _settings() -> Parameter:
    from autobalance.verbs.declaration import COMMON as MEANINGS

    return Parameter("settings", "Sequence[str]", (), (), MEANINGS["settings"][1].partition(". ")[0])


SETTINGS = _settings()


def flag_of(parameter: Parameter, option: Option) -> str:
    """Return an option as it is typed."""
    if option.flags:
        return option.flags[0]
    no = "no-" if parameter.type == "bool" and parameter.default is True else ""
    return f"--{no}{parameter.name.replace('_', '-')}"


def add_option(parser: argparse._ActionsContainer, parameter: Parameter, option: Option) -> None:
    """Add the argument or option of a parameter."""
    positional = option.positional or (parameter.default is REQUIRED and not option.flags)
    keywords: Keywords = {"help": help_of(parameter, option)}
    if parameter.type == "bool" and not option.choices:
        value = parameter.default is not True if option.value is None else option.value
        parser.add_argument(
            *(option.flags or (flag_of(parameter, option),)),
            dest=parameter.name, action="store_const", const=value, default=parameter.default, **keywords,
        )  # fmt: skip
        return
    choices = option.choices or parameter.choices
    keywords["metavar"] = option.metavar or (None if choices else _metavar(parameter, positional))
    keywords["type"] = option.normal or NUMBERS.get(parameter.type)
    if option.nargs is not None and option.read is None:
        keywords.update(nargs=option.nargs, type=float)
        parser._negative_number_matcher = NEGATIVE
    if option.repeated:
        keywords.update(action="append", default=None if parameter.default is None else [])
        if option.alone is not None:
            keywords.update(nargs="?", const=option.alone)
    elif parameter.default is not REQUIRED and not option.unset:
        keywords["default"] = parameter.default
    if choices:
        keywords["choices"] = choices
    if positional:
        if parameter.default is not REQUIRED:
            keywords["nargs"] = "?"
        parser.add_argument(parameter.name, **keywords)
        return
    flags = option.flags or (flag_of(parameter, option),)
    required = option.required or parameter.default is REQUIRED
    keywords["help"] += " (required)" if required else ""
    parser.add_argument(*flags, dest=parameter.name, required=required, **keywords)


def _metavar(parameter: Parameter, positional: bool) -> str:
    if positional:
        return parameter.name.upper()
    for unit, shown in UNITS.items():
        if parameter.name.endswith(f"_{unit}"):
            return shown
    if "Path" in parameter.type:
        return "FILE"
    return {"int": "N", "float": "X", "Sequence[float]": "X,X,..."}.get(parameter.type, "NAME")


def help_of(parameter: Parameter, option: Option) -> str:
    """Return the help of an option: what it sets, and its default.

    The meaning is the first sentence of the parameter's description; what follows ``None:`` is the default.
    """
    words, _, absent = parameter.meaning.partition("; None: ")
    if words[1:2].islower() and not words.startswith(NAMES):
        words = words[0].lower() + words[1:]
    if (parameter.type == "bool" and not option.choices) or option.required or parameter.default is REQUIRED:
        shown = ""
    elif option.usual or parameter.default is None:
        shown = option.usual or absent or "none"
    elif isinstance(parameter.default, str):
        shown = parameter.default
    elif isinstance(parameter.default, Sequence):
        shown = ",".join(f"{each:g}" if isinstance(each, float) else str(each) for each in parameter.default)
    else:
        shown = f"{parameter.default:g}"
    if option.endings is not None:
        words += f"; formats: {' '.join(option.endings())}"
    if option.repeated:
        words += "; may be repeated"
        shown = shown or "none"
    return (words + (f" (default: {shown})" if shown else "")).replace("%", "%%")
