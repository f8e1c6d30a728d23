"""Records of experiments: with pandas and without."""

import sys
from pathlib import Path

import pytest

import volccd

TABLE = Path(__file__).resolve().parents[2] / "results" / "table1.json"


def test_record_as_it_is():
    record = volccd.read_record(TABLE)
    assert record["experiment"] == "table1" and record["complete"] and len(record["rows"]) > 100


def test_frame():
    pytest.importorskip("pandas")
    frame = volccd.records(TABLE)
    assert len(frame) == len(volccd.read_record(TABLE)["rows"])
    assert frame.attrs["experiment"] == "table1" and "commit" in frame.attrs["provenance"]
    medians = frame.groupby("pipeline")["seconds"].median()
    assert medians["VolCCD+"] < medians["NavCCD"]


def test_without_pandas(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="python3-pandas.*read_record"):
        volccd.records(TABLE)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"rows": 1}', "\xff"])
def test_no_record(tmp_path, text):
    file = tmp_path / "record.json"
    file.write_text(text, encoding="latin-1")
    for path in (file, tmp_path / "absent.json"):
        with pytest.raises(volccd.InputError) as caught:
            volccd.read_record(path)
        assert str(path) in str(caught.value) and caught.value.source == str(path)
