"""Every example of README.md and of the site: Python runs and prints what is shown; commands compose."""

import contextlib
import io
import re
import shlex
import sys
import types

import pytest

from pipeline.__main__ import main
from pipeline.config.compose import compose, expand
from pipeline.multirun.index import begun_index
from pipeline.plan.planning import plan
from tests.docs.examples import PAGES, commands_of, is_command, lines_of, name_of, page_of
from tests.docs.page import ROOT
from tests.pipeline.planes import COARSE, small_plan, small_store, traced_store

READ = {name_of(path): page_of(path) for path in PAGES}
WITH_PYTHON = [name for name, page in READ.items() if page.of("python")]
COMMANDS = sorted({(name, command) for name, page in READ.items() for command in commands_of(page)})
#: Lines of other programs, as the Makefile, .ci/run or the tests of the cluster have them.
OTHER_LINES = re.compile(
    r"make [\w-]+( +#.*| QUICK=1)?"
    r"|python3 -m venv \.venv|\.venv/bin/pip install --constraint constraints\.txt --editable '\.\[test\]'"
    r"|\.venv/bin/python -m pytest.*|pytest .*|git .*"
    r"|dask (scheduler|worker) --scheduler-file .*"
    r'|eval "\$\(python -m pipeline --shell-completion \w+\)"|python -m pipeline --shell-completion fish \| source'
)
STORES = {
    "omega_fe": COARSE,
    "omega_fe-miter": ("plane=omega_fe", "gear=miter"),
    "omega_b_fe": ("plane=omega_b_fe", "plane.parameter2.num=2", "plane.parameter.num=4"),
}
#: The study of which a page shows sizes and shares.
STUDY = ("gear.b=0.5,0.6,0.7", "store.root=outputs/backlash")


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """A folder with the stores that the pages read, where they look for them."""
    folder = tmp_path_factory.mktemp("pages")
    (folder / "outputs/store").mkdir(parents=True)
    for name, overrides in STORES.items():
        planned = small_plan(*overrides)
        make = traced_store if name == "omega_fe" else small_store
        make(folder / f"outputs/store/{name}.zarr", planned)
    with contextlib.chdir(folder):
        all_settings = [compose(one) for one in expand(STUDY)]
        for settings in all_settings:
            small_store(settings.store_path, small_plan(*settings.overrides, columns=101, rows=11))
        begun_index(all_settings)[0].write()
    return folder


def write_files(page, folder):
    """The files that a page tells to write."""
    for name, text in page.files:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")


def test_there_is_something_to_check():
    assert "README.md" in WITH_PYTHON and len(WITH_PYTHON) >= 6 and len(COMMANDS) >= 30


def test_every_block_is_of_a_kind_that_is_checked():
    unchecked = []
    for name, page in READ.items():
        shown = {id(output) for _, output in page.outputs}
        files = {text for _, text in page.files}
        for block in page.blocks:
            known = block.language in ("python", "sh", "{toctree}", "{eval-rst}") or block.text in files
            if not known and id(block) not in shown:
                unchecked.append((name, block.line))
    assert unchecked == []


def test_every_line_of_the_shell_is_of_a_kind_that_is_checked():
    unknown = []
    for name, page in READ.items():
        unknown += [(name, line) for line in lines_of(page) if not (OTHER_LINES.fullmatch(line) or is_command(line))]
    assert unknown == []


@pytest.mark.parametrize("name", WITH_PYTHON)
def test_python_runs_and_prints_what_is_shown(name, stores, monkeypatch, stand_ins):
    """All of a page in one namespace and in its order, as a reader would type it."""
    monkeypatch.chdir(stores)
    page, names = READ[name], {"__name__": "page"}
    shown = {id(code): output.text for code, output in page.outputs}
    for block in page.of("python"):
        said = io.StringIO()
        # A traceback names the line of the page.
        code = compile("\n" * (block.line - 1) + block.text, name, "exec")
        with contextlib.redirect_stdout(said):
            exec(code, names)
        if id(block) in shown:
            assert said.getvalue() == shown[id(block)], f"{name}:{block.line}"


@pytest.fixture
def stand_ins(monkeypatch):
    """No window is opened, planes are small and stay in this process, and queueing systems have a stand-in: their
    commands are composed and planned."""
    monkeypatch.setenv("MPLBACKEND", "agg")
    sizes = [*COARSE[1:], "cluster=none"]
    monkeypatch.setattr("pipeline.api.compose", lambda overrides, folder: compose([*overrides, *sizes], folder))
    monkeypatch.setattr("pipeline.analysis.diagram.options.FEWEST_COLUMNS", 40)

    class Queue:
        scheduler_address = "tcp://127.0.0.1:8786"

        def __init__(self, **options):
            assert options

        def adapt(self, minimum_jobs, maximum_jobs):
            assert 0 < minimum_jobs <= maximum_jobs

    def worker_spec(name, image, n_workers):
        container = {"args": ["dask", "worker", "--name", name]}
        return {"spec": {"worker": {"replicas": n_workers, "spec": {"containers": [{**container, "image": image}]}}}}

    operator = types.ModuleType("dask_kubernetes.operator")
    operator.KubeCluster, operator.make_cluster_spec = Queue, worker_spec
    jobqueue, kubernetes = types.ModuleType("dask_jobqueue"), types.ModuleType("dask_kubernetes")
    jobqueue.SLURMCluster, kubernetes.operator = Queue, operator
    for module in (jobqueue, kubernetes, operator):
        monkeypatch.setitem(sys.modules, module.__name__, module)

    def run(words, **options):
        assert words[:3] == [sys.executable, "-m", "pipeline"]
        plan(compose(words[3:]))

    monkeypatch.setattr("subprocess.run", run)


@pytest.mark.parametrize(("name", "command"), COMMANDS)
def test_commands_compose(name, command, tmp_path, monkeypatch):
    """What is typed is a configuration, and a sweep of it can be planned."""
    page = READ[name]
    write_files(page, tmp_path)
    monkeypatch.chdir(tmp_path)
    words = [word for word in shlex.split(command) if word not in ("-m", "--help")]
    config_dir = None
    if "--config-dir" in words:
        at = words.index("--config-dir")
        config_dir, words = words[at + 1], words[:at] + words[at + 2 :]
    for combination in expand(words):
        settings = compose(combination, config_dir)
        if "sweep" in settings.config.stages:
            plan(settings)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, page in READ.items() if commands_of(page)])
def test_commands_run(name, tmp_path, monkeypatch):
    """All commands of a page in their order, on small planes in this process; the map that they start from is there."""
    page = READ[name]
    write_files(page, tmp_path)
    monkeypatch.chdir(tmp_path)
    # A page that is served is served until Ctrl-C.
    monkeypatch.setattr("pipeline.explorer.server.run_server", lambda server: server.stop())
    small = ["cluster=none", "plane.sweep.num=41", "plane.parameter.num=5", "figures.formats=[png]"]
    short = ["attractors.columns=6", "attractors.rows=3", "attractors.starts=3", "attractors.slice=4"]
    first = ["-m", "plane=omega_fe,omega_b,omega_alpha,omega_fpm", *small, "stages=[sweep,boundaries]"]
    assert main(first) == 0
    assert main(["plane=omega_b", "gear=miter", *small, "stages=[sweep,boundaries]"]) == 0
    for command in commands_of(page):
        words = shlex.split(command)
        if {"cluster=scheduler", "cluster=slurm"} & {*words} or any("://" in word for word in words):
            continue  # real schedulers, jobs and object stores are tested in tests/pipeline
        third = ["plane.parameter2.num=2"] if "plane=omega_b_fe" in words else []
        words = [re.sub(r"num:\d+", "num:2", re.sub(r"debug\.row=\d+", "debug.row=3", word)) for word in words]
        # A plane is given as many as it has.
        words = [re.sub(r"^attractors\.(columns|rows)=\d+", r"attractors.\1=3", word) for word in words]
        given = {word.partition("=")[0] for word in words}
        extra = [word for word in [*small, *short, *third] if word.partition("=")[0] not in given]
        assert main([*words, *extra]) == 0, command


def test_make_targets_that_pages_name_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([\w-]+):", makefile, flags=re.MULTILINE))
    for path in PAGES:
        code = "\n".join(block.text for block in READ[name_of(path)].of("sh"))
        named = re.findall(r"^make ([\w-]+)", code, flags=re.MULTILINE)
        named += re.findall(r"`make ([\w-]+)[^`]*`", path.read_text(encoding="utf-8"))
        assert set(named) <= targets, path


def test_the_first_commands_are_those_of_make_and_of_ci():
    makefile, ci = ((ROOT / name).read_text(encoding="utf-8") for name in ("Makefile", ".ci/run"))
    assert "python -m pipeline plane=omega_fe" in makefile and "python -m pytest" in makefile
    assert all(f"make {target}\n" in ci for target in ("check", "docs", "test"))
    assert {"make map", "make test"} <= {
        line.partition("  ")[0] for block in READ["README.md"].of("sh") for line in block.text.splitlines()
    }
