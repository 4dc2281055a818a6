"""Lines of a run: paths as they are typed where the reader is, and whole in the log."""

import pytest

from pipeline.run.progress import Reporter


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("rows into {here}/outputs/a.zarr (1 s)", "rows into outputs/a.zarr (1 s)"),
        ("store.root={here}/outputs 'x'", "store.root=outputs 'x'"),
        ("file://{here}/outputs", "file://{here}/outputs"),
        ("/other{here}/outputs", "/other{here}/outputs"),
        ("{here}-b/outputs", "{here}-b/outputs"),
        ("list: no stores in {here}", "list: no stores in {here}"),
    ],
)
def test_paths_are_printed_as_typed_here_and_logged_whole(tmp_path, monkeypatch, capsys, text, printed):
    monkeypatch.chdir(tmp_path)
    reporter = Reporter()
    reporter.log = tmp_path / "run.log"
    for said in (reporter.line, reporter.error):
        said(text.format(here=tmp_path))
    out, err = capsys.readouterr()
    assert out == printed.format(here=tmp_path) + "\n"
    assert err == f"error: {printed.format(here=tmp_path)}\n"
    assert reporter.log.read_text().count(text.format(here=tmp_path)) == 2


def test_lines_are_printed_where_the_folder_is_gone(tmp_path, monkeypatch, capsys):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    Reporter().line("rows into /elsewhere/a.zarr")
    assert capsys.readouterr().out == "rows into /elsewhere/a.zarr\n"
