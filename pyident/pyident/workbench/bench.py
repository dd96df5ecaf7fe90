"""What all pages of one workbench share: the project, the work under way, the results so far."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pyident.workbench import work
from pyident.workbench.jobs import Job
from pyident.workbench.project import Project, Role, Version, command

RESULTS = "results"


@dataclass
class Bench:
    """The shared state; `revision` grows with every change, so that each page knows when to draw again.

    results   (what, inputs) -> outcome, so that a result never outlives the inputs that it is of
    """

    project: Project
    jobs: dict[str, Job] = field(default_factory=dict)
    results: dict[tuple[str, work.Inputs], Any] = field(default_factory=dict)
    message: str = ""
    revision: int = 0
    _asked: dict[str, work.Inputs] = field(default_factory=dict)
    _pending: Version = field(default_factory=lambda: Version(""))

    @property
    def inputs(self) -> work.Inputs:
        """The model in use and the logs as they are sorted now."""
        p = self.project
        paths = {role: tuple(str(p.path(n)) for n in p.with_role(role)) for role in ("fit", "hold out")}
        mapping = str(p.path(p.mapping)) if p.mapping else ""
        return work.Inputs(p.model_path(), paths["fit"], paths["hold out"], mapping)

    def result(self, what: str) -> Any:
        """The outcome for exactly the present inputs, None where there is none."""
        return self.results.get((what, self.inputs))

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
        self.project = project
        self.revision += 1

    def start(self, what: str, title: str, *arguments: Any) -> None:
        """Begin work; an earlier one of the same kind is cancelled. Arguments: the function and its own."""
        if what in self.jobs:
            self.jobs[what].cancel()
        self._asked[what] = self.inputs
        self.jobs[what] = Job(title, *arguments)
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
                self.results[what, self._asked[what]] = job.result
                if what == "add":
                    self._take_version(job.result)
                elif what == "identify":
                    self._take_fit(job.result)

    # What the buttons do.

    def check(self) -> None:
        """Read every log that takes part and ask what is wrong with it."""
        inputs = self.inputs
        names = [*inputs.logs, *inputs.heldout]
        if names and inputs.model:
            self.start("check", "checking the logs", work.checked, inputs, names)

    def compare(self) -> None:
        """Ask where the model fails."""
        inputs, file = self.inputs, self._file("compare")
        self._log("compare", inputs, "--json", file)
        self.start("compare", "comparing model and logs", work.compared, inputs, self._path(file))

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
        names = [Path(inputs.model).name, *inputs.log_names(), "-o", output.name, "--json", file]
        self._pending = Version(output.name, self.project.model, "identified", command("identify", names))
        self.start("identify", "identifying", work.identified, inputs, str(output), self._path(file))

    def add(self, effect: str, joint: int) -> None:
        """Add a law, fit it and judge it on held-out data."""
        inputs, file = self.inputs, self._file(f"add_{effect}_{joint}")
        output = self._next_model(f"with_{effect}_{joint}")
        words = [Path(inputs.model).name, effect, "--joint", str(joint), *inputs.log_names()]
        line = command("add", words, inputs.options(), "-o", output.name, "--json", file)
        self._pending = Version(output.name, self.project.model, f"{effect} at joint {joint}", line)
        title = f"adding {effect} at joint {joint}"
        self.start("add", title, work.added, inputs, effect, joint, str(output), self._path(file))

    def assign(self, log: str, role: Role) -> None:
        """Let a log serve for something else."""
        self.change(self.project.having_role(log, role))

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
        version = replace(self._pending, fall=tuple(extended.gains))
        self.change(self.project.extended(version).after(version.command))

    def _take_fit(self, _: Any) -> None:
        self.change(self.project.extended(self._pending).after(self._pending.command))

    def _log(self, verb: str, inputs: work.Inputs, *words: str) -> None:
        logs = [*inputs.log_names(), *(Path(log).name for log in inputs.heldout)]
        mapping = ["--mapping", Path(inputs.mapping).name] if inputs.mapping else []
        self.change(self.project.after(command(verb, Path(inputs.model).name, logs, mapping, *words)))

    def _file(self, stem: str) -> str:
        return str(Path(RESULTS) / f"{stem}_v{self.project.current}.json")

    def _path(self, name: str) -> str:
        return str(self.project.folder / name)

    def _next_model(self, what: str) -> Path:
        return self.project.folder / self.project.free_name(what, ".toml")
