"""Matrices of one's own from lists, CSV and NPZ files; what is no matrix is said in one line."""

import io
import zipfile

import numpy as np
import pytest

from pipeline.config.compose import compose
from pipeline.config.matrix_files import numbers_of, read_matrix, read_npz
from pipeline.config.number_files import NumbersError
from pipeline.errors import ConfigurationError
from pipeline.plan.planning import plan

STOP = ("gear=stop", "plane=omega_gap")


def written(folder, name, text):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize(
    "text", ["1,2\n3,4\n", "# K\n1;2\n\n3;4", "1 2\n3  4", "1\t2\n3\t4\n", "\ufeff1, 2\n3, 4 # row\n"]
)
def test_a_csv_file_is_read_however_it_is_separated(tmp_path, text):
    np.testing.assert_array_equal(read_matrix(written(tmp_path, "k.csv", text)), [[1, 2], [3, 4]])


def test_rows_columns_and_complex_numbers(tmp_path):
    assert read_matrix(written(tmp_path, "row.csv", "1,0,2")).shape == (3,)
    assert read_matrix(written(tmp_path, "column.csv", "1\n0\n2")).shape == (3,)
    np.testing.assert_array_equal(
        read_matrix(written(tmp_path, "load.csv", "1,0\n0.1-0.2j,1j")), [[1, 0], [0.1 - 0.2j, 1j]]
    )
    np.testing.assert_array_equal(numbers_of([[1, "0.5j"], [2.0, "3"]]), [[1, 0.5j], [2, 3]])


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("", "empty"),
        ("1,2\n3\n", "line 2"),
        ("1,a\n", "'a'"),
        ("1,nan\n", "'nan'"),
        ("1,1e40\n", "'1e40'"),
        ("M,C\n1,2", "line 1"),
    ],
)
def test_what_is_no_matrix_is_refused(tmp_path, text, names):
    with pytest.raises(NumbersError, match=names):
        read_matrix(written(tmp_path, "bad.csv", text))


def test_files_that_are_none_or_too_large_are_refused(tmp_path):
    for path in (str(tmp_path), str(tmp_path / "none.csv"), written(tmp_path, "large.csv", "1," * 1_500_000), "a\0b"):
        with pytest.raises(NumbersError):
            read_matrix(path)
        with pytest.raises(NumbersError):
            read_npz(path)


def test_an_npz_file_holds_numbers_of_a_bearable_size(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, mass=np.eye(2), load=np.ones((1, 2)) * 1j)
    assert set(read_npz(str(path))) == {"mass", "load"}
    for bad in (np.array(["a"]), np.array([object()], dtype=object), np.array([np.inf])):
        np.savez(path, mass=bad)
        with pytest.raises(NumbersError):
            read_npz(str(path))
    # 80 MB of zeros, in a small file.
    buffer = io.BytesIO()
    np.save(buffer, np.zeros(10**7))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("mass.npy", buffer.getvalue())
    with pytest.raises(NumbersError, match="larger than"):
        read_npz(str(path))


def test_lists_csv_and_npz_make_one_plan(tmp_path):
    """What is in the files belongs to the plan, and not where they are."""
    wanted = plan(compose([*STOP]))
    arrays = wanted.gear["matrices"]
    for name in ("mass", "damping", "stiffness"):
        np.savetxt(tmp_path / f"{name}.csv", arrays[name], delimiter=";")
    files = [f"gear.system.{name}={tmp_path}/{name}.csv" for name in ("mass", "damping", "stiffness")]
    assert plan(compose([*STOP, *files])).inputs == wanted.inputs
    path = tmp_path / "all.npz"
    whole = {name: np.array(array) for name, array in arrays.items() if name != "load"}
    np.savez(path, **whole, load=np.array(arrays["load"]) @ (1.0, 1.0j), front_gap=0.0, back_gap=np.inf)
    given = plan(compose(["gear=system", "plane=omega_gap", f"gear.system.file={path}"]))
    assert given.inputs == wanted.inputs
    np.savez(path, **{**whole, "mass": np.diag([1.0, 1.5])}, load=np.array(arrays["load"]) @ (1.0, 1.0j), front_gap=0.0)
    changed = plan(compose(["gear=system", "plane=omega_gap", f"gear.system.file={path}"]))
    assert changed.fingerprint != wanted.fingerprint


@pytest.mark.parametrize(
    ("overrides", "names"),
    [
        (["gear.system.mass=[[1,2]]"], ["gear.system.mass", "1 x 2", "2 x 2"]),
        (["gear.system.mass=[[1,2],[3]]"], ["gear.system.mass", "one length"]),
        (["gear.system.mass=[[1,1],[1,1]]"], ["gear.system.mass", "invertible"]),
        (["gear.system.mass=[[1,1j],[0,1]]"], ["gear.system.mass", "real"]),
        (["gear.system.force=nowhere.csv"], ["gear.system.force", "nowhere.csv"]),
        (["gear.system.contact=null"], ["gear.system.contact"]),
        (["gear.system.load=[[1j,0]]"], ["gear.system.load", "real"]),
        (["gear.system.front_gap=null"], ["gear.system.front_gap"]),
        (["gear.system.front_gap=inf"], ["gear.system.front_gap", "finite"]),
        (["gear.system.back_gap=nan"], ["gear.system.back_gap"]),
        (["gear.system.file=nowhere.npz"], ["gear.system.file", "nowhere.npz"]),
        (["gear.system.alpha=0.2"], ["gear.system.alpha", "varying_force"]),
        (["gear.system.alpha_harmonics=[[0.1,0]]"], ["gear.system.alpha_harmonics", "varying_force"]),
    ],
)
def test_wrong_arrays_are_named_with_what_is_allowed(overrides, names):
    with pytest.raises(ConfigurationError) as caught:
        plan(compose([*STOP, *overrides]))
    said = str(caught.value)
    assert "\n" not in said and all(name in said for name in names), said


def test_an_array_is_not_given_twice(tmp_path):
    np.savez(tmp_path / "m.npz", mass=np.eye(2))
    with pytest.raises(ConfigurationError, match=r"gear\.system\.mass .*gear\.system\.file"):
        plan(compose([*STOP, f"gear.system.file={tmp_path}/m.npz"]))
    np.savez(tmp_path / "m.npz", masses=np.eye(2))
    with pytest.raises(ConfigurationError, match="'masses'"):
        plan(compose([*STOP, f"gear.system.file={tmp_path}/m.npz"]))
