"""Compiled code runs what its sources say, wherever it is kept and whoever runs it."""

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tendon_mj.compilation import folders, sources

PACKAGE = Path(__file__).parents[1] / "tendon_mj"
CALLEE = """
from tendon_mj.compilation import compiled

@compiled
def scaled(x):
    return {factor} * x
"""
CALLER = """
from numba import types
from tendon_mj.compilation import callback, compiled
from tendon_mj.sheath.callee import scaled

@compiled
def called_by_python(x):
    return scaled(x)

@callback(types.float64(types.float64))
def called_by_c(x):
    return scaled(x)
"""
PROBE = """
from tendon_mj.compilation import announced
with announced():
    from tendon_mj.plugin import caller
print(caller.called_by_python(1.0), caller.called_by_c.ctypes(1.0))
"""
# sizes differ, so that Python notices a change within a second too
BEFORE, AFTER = "2.0 2.0\n", "30.0 30.0\n"


class Copy:
    """The package's compilation with two compiled functions, one of which calls the other."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.package = root / "site" / "tendon_mj"
        self.home, self.temporary = root / "home", root / "tmp"
        self.home.mkdir()
        self.temporary.mkdir()
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(PACKAGE / "compilation", self.package / "compilation", ignore=ignored)
        for name in ("sheath", "plugin"):
            (self.package / name).mkdir()
            (self.package / name / "__init__.py").touch()
        (self.package / "__init__.py").touch()
        (self.package / "plugin" / "caller.py").write_text(CALLER)
        self.scale_by("2.0")

    def scale_by(self, factor: str) -> None:
        (self.package / "sheath" / "callee.py").write_text(CALLEE.format(factor=factor))

    def lock_package(self) -> None:
        """Nothing can be written beside the package, by the administrator neither."""
        shutil.rmtree(self.package / "__pycache__", ignore_errors=True)
        (self.package / "__pycache__").touch()

    def lock_home(self) -> None:
        self.home.rmdir()
        self.home.touch()

    @property
    def environment(self) -> dict[str, str]:
        inherited = {k: v for k, v in os.environ.items() if k not in _CHANGED}
        return inherited | {
            "PYTHONPATH": str(self.root / "site"),
            "HOME": str(self.home),
            "TMPDIR": str(self.temporary),
        }

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, "-W", "error", *(arguments or ("-c", PROBE))],
            env=self.environment,
            cwd=self.root,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def run(self, *arguments: str) -> tuple[str, list[str]]:
        """Output of a fresh process on stdout, and its lines on stderr."""
        process = self.start(*arguments)
        out, err = process.communicate(timeout=300)
        assert process.returncode == 0, err
        return out, err.splitlines()

    def kept(self, *, below: Path) -> list[Path]:
        return sorted(below.rglob("*.bin"))


_CHANGED = {"NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT", "XDG_CACHE_HOME", "PYTHONDONTWRITEBYTECODE"}


@pytest.fixture
def copy(tmp_path):
    return Copy(tmp_path)


@pytest.mark.parametrize("installed", [False, True], ids=["clone", "installed"])
def test_a_changed_callee_changes_the_result_and_changed_back_it_returns(copy, installed):
    if installed:
        copy.lock_package()
    place = copy.home / ".cache" if installed else copy.package / "__pycache__"
    out, said = copy.run()
    assert out == BEFORE
    assert len(said) == 1
    assert "once" in said[0]
    assert copy.run() == (BEFORE, [])
    first = set(copy.kept(below=copy.root))
    copy.scale_by("30.0")
    assert copy.run()[0] == AFTER
    copy.scale_by("2.0")
    assert copy.run() == (BEFORE, [])  # from the machine code of the first run
    assert first < set(copy.kept(below=place)) == set(copy.kept(below=copy.root))
    assert str(next(iter(first)).parent) in copy.run("-m", "tendon_mj.compilation")[0]


def test_where_nothing_can_be_written_a_private_temporary_folder_serves(copy):
    copy.lock_package()
    copy.lock_home()
    out, said = copy.run()
    folder = copy.temporary / f"tendon_mj-{os.geteuid()}"
    assert out == BEFORE
    assert len(said) == 1
    assert str(folder) in said[0]
    assert folder.stat().st_mode & 0o777 == 0o700
    assert copy.run() == (BEFORE, [])


def test_where_others_may_write_nothing_is_kept_and_one_line_says_so(copy):
    copy.lock_package()
    copy.lock_home()
    folder = copy.temporary / f"tendon_mj-{os.geteuid()}"
    folder.mkdir()
    folder.chmod(0o777)
    for _ in range(2):
        out, said = copy.run()
        assert out == BEFORE
        assert len(said) == 1
        assert "in every process" in said[0]
    assert not copy.kept(below=copy.root)


def test_damaged_machine_code_is_compiled_again(copy):
    copy.run()
    for file in copy.kept(below=copy.root):
        os.truncate(file, file.stat().st_size // 2)
    assert copy.run()[0] == BEFORE
    assert copy.run() == (BEFORE, [])


def test_of_processes_that_start_at_once_one_compiles_and_all_are_right(copy):
    started = [copy.start() for _ in range(3)]
    ended = [process.communicate(timeout=300) for process in started]
    assert [out for out, _ in ended] == 3 * [BEFORE]
    assert sum("compiling" in err for _, err in ended) == 1
    assert not list(copy.root.rglob("*.tmp"))


def test_a_process_that_outlives_its_sources_neither_reads_nor_keeps_machine_code(copy):
    copy.run()
    kept = copy.kept(below=copy.root)
    changing = (
        "from pathlib import Path\nimport tendon_mj.compilation\n"
        "path = Path('site/tendon_mj/sheath/callee.py')\n"
        "path.write_text(path.read_text().replace('2.0', '30.0'))\n"
    )
    assert copy.run("-c", changing + PROBE)[0] == AFTER
    assert copy.kept(below=copy.root) == kept
    copy.scale_by("2.0")
    assert copy.run() == (BEFORE, [])


def test_a_folder_is_trusted_if_nobody_else_could_have_written_in_it(tmp_path, monkeypatch):
    folder = tmp_path / "own"
    folder.mkdir(mode=0o755)
    assert folders.is_trusted(folder)
    for mode in (0o775, 0o757):
        folder.chmod(mode)
        assert not folders.is_trusted(folder)
    folder.chmod(0o700)
    assert folders.is_trusted(folder)
    (tmp_path / "link").symlink_to(folder)
    assert not folders.is_trusted(tmp_path / "link")
    assert not folders.is_trusted(tmp_path / "none")
    if os.geteuid() == 0:
        os.chown(folder, 4711, -1)
    else:
        monkeypatch.setattr(os, "geteuid", lambda: 4711)
    assert not folders.is_trusted(folder)


def test_machine_code_is_kept_for_the_sources_used_last(tmp_path):
    folder = tmp_path / ("f" * 16)
    folder.mkdir()
    names = [f"{k:016x}" for k in range(6)]
    for age, name in enumerate(names):
        (tmp_path / name).mkdir()
        os.utime(tmp_path / name, (1000.0 - age, 1000.0 - age))
    (tmp_path / "of the user").mkdir()
    folders.delete_old(folder)
    kept = {path.name for path in tmp_path.iterdir()}
    assert kept == {*names[:3], folder.name, "of the user"}


def test_the_digest_covers_every_module_with_compiled_functions():
    for path in PACKAGE.rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        imported = {
            (node.module or "") if isinstance(node, ast.ImportFrom) else alias.name
            for node in ast.walk(tree)
            if isinstance(node, (ast.Import, ast.ImportFrom))
            for alias in node.names
        }
        if any(name.startswith("tendon_mj.compilation") for name in imported):
            assert path.relative_to(PACKAGE).parts[0] in sources.COMPILED, path
        assert path.parts[-2] == "compilation" or not any(
            name.startswith(("numba.core.decorators", "numba.core.ccallback")) for name in imported
        )


def test_the_digest_follows_text_names_and_versions(copy, monkeypatch):
    monkeypatch.setattr(sources, "PACKAGE", copy.package)
    first = sources.read()
    copy.scale_by("30.0")
    second = sources.read()
    copy.scale_by("2.0")
    assert first.digest == sources.read().digest != second.digest
    (copy.package / "sheath" / "callee.py").rename(copy.package / "sheath" / "other.py")
    assert sources.read().digest not in (first.digest, second.digest)
    (copy.package / "sheath" / "other.py").rename(copy.package / "sheath" / "callee.py")
    assert sources.read().digest == first.digest
    monkeypatch.setattr(sources, "_version", lambda tool: "another")
    assert sources.read().digest != first.digest


def test_a_package_without_sources_has_no_digest(copy, monkeypatch):
    monkeypatch.setattr(sources, "PACKAGE", copy.root)
    with pytest.raises(OSError, match="no sources"):
        sources.read()


def test_bytecode_that_python_failed_to_renew_is_not_kept_as_that_of_the_new_source(copy):
    callee = copy.package / "sheath" / "callee.py"
    second = 1_750_000_000_000_000_000  # [ns]
    for factor in ("2.0", "3.0"):  # of one size, written within one second
        copy.scale_by(factor)
        os.utime(callee, ns=(second, second))
        assert copy.run()[0] == "2.0 2.0\n"  # Python itself does not notice the second
    os.utime(callee)
    assert copy.run()[0] == "3.0 3.0\n"


def test_code_has_one_fingerprint_whatever_its_lines_and_another_when_a_constant_changes():
    def of(text):
        return sources.fingerprint(compile(text, "module", "exec"))

    assert of("def f(x):\n    return 2.0 * x") == of("# why\n\ndef f(x):\n    return 2.0 * x")
    assert of("def f(x):\n    return 2.0 * x") != of("def f(x):\n    return 3.0 * x")
    assert of("LIMIT = 1") != of("LIMIT = 1.0")
    assert of("x in {'a', 'b', 'c'}") == of("x in {'a', 'b', 'c'}")


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="Windows has other permissions")
def test_a_file_that_others_may_write_is_not_read(tmp_path):
    file = tmp_path / "machine_code.bin"
    file.write_bytes(b"code")
    file.chmod(0o600)
    assert folders.read_trusted(file) == b"code"
    file.chmod(0o666)
    with pytest.raises(PermissionError, match="somebody else"):
        folders.read_trusted(file)
