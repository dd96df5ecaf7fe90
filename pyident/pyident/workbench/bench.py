"""What all pages of one workbench share: the project, the work under way, the results so far."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from pyident.workbench import commands, work
from pyident.workbench.jobs import Job
from pyident.workbench.kept import keep, kept
from pyident.workbench.project import Project, Role, Version, command

RESULTS = "results"


@dataclass
class Bench:
    """The shared state; `revision` grows with every change, so that each page knows when to draw again.

    results   (what, inputs) -> outcome, so that a result never outlives the inputs that it is of
    told      the command that does what was clicked last
    """

    project: Project
    jobs: dict[str, Job] = field(default_factory=dict)
    results: dict[tuple[str, work.Inputs], Any] = field(default_factory=dict)
    message: str = ""
    told: str = ""
    revision: int = 0
    _asked: dict[str, work.Inputs] = field(default_factory=dict)
    _waiting: list[int] = field(default_factory=list)
    _pending: Version = field(default_factory=lambda: Version(""))

    @property
    def inputs(self) -> work.Inputs:
        """The model in use and the logs as they are sorted now."""
        return self.inputs_of(None)

    def inputs_of(self, number: int | None) -> work.Inputs:
        """The same with another version of the model."""
        p = self.project if number is None else self.project.at_version(number)
        paths = {role: tuple(str(p.path(n)) for n in p.with_role(role)) for role in ("fit", "hold out")}
        mapping = str(p.path(p.mapping)) if p.mapping else ""
        return work.Inputs(p.model_path(), paths["fit"], paths["hold out"], mapping)

    def result(self, what: str, number: int | None = None) -> Any:
        """The outcome for exactly the present inputs (of another version), None where there is none."""
        inputs = self.inputs_of(number)
        if (what, inputs) not in self.results:
            self.results[what, inputs] = kept(self.project.folder, what, inputs)  # of an earlier server
        return self.results[what, inputs]

    @property
    def last_added(self) -> work.Outcome | None:
        """What came of the law that was added last: to this version, or to that before it."""
        now = self.result("add")
        current = self.project.current
        return now if now is not None or not current else self.result("add", current - 1)

    @property
    def checked(self) -> dict[str, list[str]]:
        """Log -> sentences of its checks, for exactly the present inputs."""
        return self.result("check") or {}

    @property
    def sound(self) -> bool:
        """Whether the checks of the present inputs have passed: the lock of every further place."""
        sentences = self.checked
        chosen = [Path(p).name for p in (*self.inputs.logs, *self.inputs.heldout)]
        return bool(chosen) and all(
            name in sentences and not sentences[name][0].startswith(work.REFUSED) for name in chosen
        )

    def change(self, project: Project) -> None:
        """Take a new state of the project and write it."""
        project.save()
        if len(project.commands) > len(self.project.commands):
            self.told = project.commands[-1]
        self.project = project
        self.revision += 1

    def start(self, what: str, title: str, function: Any, *arguments: Any) -> None:
        """Begin work; an earlier one of the same kind is cancelled."""
        if what in self.jobs:
            self.jobs[what].cancel()
        inputs = next((a for a in arguments if isinstance(a, work.Inputs)), self.inputs)
        self._asked[what] = inputs
        self.jobs[what] = Job(title, function, *arguments)
        self.message = ""
        self.revision += 1

    def collect(self) -> None:
        """Take up what has ended since the last call."""
        for what, job in list(self.jobs.items()):
            if job.running:
                continue
            del self.jobs[what]
            self.revision += 1
            if job.state == "failed":
                self.message = f"{job.title}: {job.error}"
            elif job.state == "done":
                self._hold(what, self._asked[what], job.result)
                if what == "add":
                    self._take_version(job.result)
                elif what == "identify":
                    self._take(self._pending)
                    self._hold(what, self.inputs, job.result)  # the page looks at what was made
                elif what == "import":
                    self.change(self.project.starting_from(self._pending.model).after(self._pending.command))
                    self.message = " ".join(job.result)
                elif what == "compare":
                    if job.result.comparison.floor is not None:  # else it could not be simulated
                        self.start("ask", "asking every law", work.asked, self._asked[what], job.result)
                    self._next_comparison()

    # What the buttons do.

    def check(self) -> None:
        """Read every log that takes part and ask what is wrong with it."""
        inputs = self.inputs
        names = [*inputs.logs, *inputs.heldout]
        if names and inputs.model:
            self.told = commands.checking(inputs)
            self.start("check", "checking the logs", work.checked, inputs, names)

    def compare(self, number: int | None = None) -> None:
        """Ask where a version of the model fails; the one in use without a number."""
        inputs, file = self.inputs_of(number), self._file("compare", number)
        self.change(self.project.after(commands.comparing(inputs, file)))
        self.start(
            "compare",
            f"comparing {Path(inputs.model).name} and the logs",
            work.compared,
            inputs,
            self._path(file),
        )

    def compare_all(self, numbers: Sequence[int]) -> None:
        """Compare several versions, one after the other."""
        self._waiting = list(numbers)
        self._next_comparison()

    def _next_comparison(self) -> None:
        if self._waiting:
            self.compare(self._waiting.pop(0))

    def diagnose(self) -> None:
        """Ask which effect is missing."""
        inputs, file = self.inputs, self._file("diagnose")
        line = command(
            "diagnose", Path(inputs.model).name, inputs.log_names(), inputs.options(), "--json", file
        )
        self.change(self.project.after(line))
        self.start("diagnose", "diagnosing", work.diagnosed, inputs, self._path(file))

    def identify(self) -> None:
        """Fit the model's parameters to the logs."""
        inputs, file = self.inputs, self._file("identify")
        output = self._next_model("identified")
        names = [Path(inputs.model).name, *inputs.log_names()]
        line = self.told = command("identify", names, inputs.options(), "-o", output.name, "--json", file)
        self._pending = Version(output.name, self.project.model, "identified", line)
        self.start("identify", "identifying", work.identified, inputs, str(output), self._path(file))

    def add(self, effect: str, joint: int) -> None:
        """Add a law, fit it and judge it on held-out data."""
        from pyident.report.next_steps import words_of

        asked = words_of(effect, joint)
        inputs, file = self.inputs, self._file(f"add_{asked[0]}_{joint}")
        output = self._next_model(f"with_{asked[0]}_{joint}")
        words = [Path(inputs.model).name, *asked, *inputs.log_names()]
        line = self.told = command("add", words, inputs.options(), "-o", output.name, "--json", file)
        self._pending = Version(output.name, self.project.model, f"{effect} at joint {joint}", line)
        title = f"adding {effect} at joint {joint}"
        self.start("add", title, work.added, inputs, effect, joint, str(output), self._path(file))

    def plan(self, separate: tuple[str, ...] = (), reveal: str = "") -> None:
        """Design the motion that tells two laws (`effect@joint`) apart, or shows one."""
        inputs, file = self.inputs, self._file("excite")
        output = self.project.free_name("plan", ".csv")
        asked = ["--separate", *separate] if separate else ["--reveal", reveal]
        line = command("excite", Path(inputs.model).name, asked, "-o", output, "--json", file)
        self.change(self.project.having_role(output, "leave out").after(line))
        path = self._path(output)
        self.start(
            "plan", "planning a motion", work.planned, inputs, separate, reveal, path, self._path(file)
        )

    def bundle(self) -> None:
        """Pack the model in every format."""
        inputs, output = (
            self.inputs,
            self.project.free_name(f"{Path(self.project.model).stem}_bundle", ".zip"),
        )
        script = self.project.script()
        self.told = commands.packing(inputs, Path(self.project.model).stem)
        self.start("bundle", f"packing {output}", work.bundled, inputs.model, self._path(output), script)

    def bring(self, file: str, flexible: tuple[int, ...], twist: tuple[int, ...]) -> None:
        """Take a URDF or MJCF of the folder as a robot file.

        flexible, twist   joints that twist and bend, or only twist
        """
        output = self.project.free_name(Path(file).stem, ".toml")
        words = ["import", file, "-o", output]
        for option, joints in (("--flexible", flexible), ("--twist", twist)):
            words += [option, ",".join(map(str, joints))] if joints else []
        self.told = command("robots", words)
        self._pending = Version(output, command=self.told)
        path = str(self.project.path(file))
        self.start("import", f"reading {file}", work.imported, path, self._path(output), flexible, twist)

    def propose(self, log: str) -> None:
        """Ask what a file's columns seem to be."""
        path = str(self.project.path(log))
        self.told = commands.inspecting(self.inputs, log, self.project.free_name("mapping", ".toml"))
        self.start("propose", f"reading {log}", work.proposed, path, self.inputs.model)

    def use_mapping(self, text: str) -> None:
        """Write a mapping and read the logs by it."""
        name = self.project.free_name("mapping", ".toml")
        self.project.path(name).write_text(text, encoding="utf-8")
        self.change(replace(self.project, mapping=name))
        self.told = commands.checking(self.inputs)

    def assign(self, log: str, role: Role) -> None:
        """Let a log serve for something else."""
        self.change(self.project.having_role(log, role))
        self.told = commands.judging(self.inputs)

    def choose(self, model: str) -> None:
        """Begin with another model."""
        self.change(self.project.starting_from(model))
        self.told = commands.checking(self.inputs)

    def use(self, number: int) -> None:
        """Take another version of the model. Raises ProjectError."""
        self.change(self.project.at_version(number))
        self.told = commands.checking(self.inputs)

    def export(self, ending: str, fmi: Literal[2, 3] = 2) -> None:
        """Write the model in the format of a file's ending."""
        inputs = self.inputs
        name = self.project.free_name(Path(self.project.model).stem, ending)
        self.change(self.project.after(commands.exporting(inputs, name, fmi)))
        self.start("export", f"writing {name}", work.exported, inputs.model, self._path(name), fmi)

    def report(self, what: Literal["compare", "diagnose"]) -> None:
        """Write the page of a result that is there."""
        name = self.project.free_name(f"{Path(self.project.model).stem}_{what}", ".html")
        self.change(self.project.after(commands.reporting(self.inputs, what, name)))
        self.start("report", f"writing {name}", work.reported, self.result(what), self._path(name))

    def cancel(self, what: str) -> None:
        """Stop work that is under way."""
        if what in self.jobs:
            self.jobs.pop(what).cancel()
            self.revision += 1

    def close(self) -> None:
        """Stop everything."""
        for what in list(self.jobs):
            self.cancel(what)

    def _take_version(self, extended: Any) -> None:
        if not extended.accepted:
            self.message = f"{self._pending.what} was refused: {extended.reason}"
            return
        self._take(replace(self._pending, fall=tuple(extended.gains)))
        self.compare()

    def _take(self, version: Version) -> None:
        """A new version; the logs that made it have passed their checks."""
        checked = self.result("check")
        self.change(self.project.extended(version).after(version.command))
        self._hold("check", self.inputs, checked)

    def _hold(self, what: str, inputs: work.Inputs, result: Any) -> None:
        """Remember a result, beyond the end of the server where it can be written."""
        self.results[what, inputs] = result
        try:
            keep(self.project.folder, what, inputs, result)
        except OSError as error:
            self.message = f"the result is not kept: {error}"

    def _file(self, stem: str, number: int | None = None) -> str:
        number = self.project.current if number is None else number
        return str(Path(RESULTS) / f"{stem}_v{number}.json")

    def _path(self, name: str) -> str:
        return str(self.project.folder / name)

    def _next_model(self, what: str) -> Path:
        return self.project.folder / self.project.free_name(what, ".toml")
