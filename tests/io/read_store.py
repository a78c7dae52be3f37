"""Reads stores with plain h5py and checks every dataset against the table of docs/STORE.md.

usage: read_store.py MAKE_EXAMPLE_STORE docs/STORE.md
Exit code 77 (skipped) when h5py is not installed.
"""
import os
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy
except ImportError:
    sys.exit(77)

DTYPES = {"f32": "<f4", "f64": "<f8", "i32": "<i4", "u8": "u1", "u32": "<u4", "u64": "<u8"}
DESCRIPTORS = {"d2": 64, "a3": 5}
STATUSES = ["ok", "empty", "unreadable", "unsupported_format", "non_finite", "index_out_of_range", "zero_area",
            "zero_density", "too_large", "timeout", "out_of_memory", "crashed", "internal", "missing_attribute",
            "incomplete"]
SPLITS = ["none", "train", "test", "validation"]
METHODS = ["none", "conformal", "mean-value", "direct", "anisotropic", "balanced"]
ORDER_REASONS = ["as_asked", "flipped", "winding", "not_finite", "work_limit"]


def layout_table(page):
    """Rows of the table: (path, second name, type, shape, fill, unit, meaning)."""
    rows = []
    for line in open(page, encoding="utf-8"):
        if not line.startswith("| `/"):
            continue
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        names = [name.strip("`") for name in cells[0].split(", also ")]
        rows.append([names[0], names[1] if len(names) > 1 else None] + cells[1:])
    return rows


def expected_shape(text, rows, samples, width):
    return tuple({"M": rows, "N": samples, "B": width}.get(word) or int(word)
                 for word in text.strip("()").split(", "))


def check_type(dataset, kind, path):
    if kind == "enum u8":
        names = {"status": STATUSES, "method": METHODS, "split": SPLITS,
                 "order_reason": ORDER_REASONS}[path.rsplit("/", 1)[1]]
        assert h5py.check_enum_dtype(dataset.dtype) == {name: i for i, name in enumerate(names)}, path
    elif kind == "UTF-8, fixed width":
        info = h5py.check_string_dtype(dataset.dtype)
        assert info.encoding == "utf-8" and info.length >= 1, path
    else:
        assert dataset.dtype == numpy.dtype(DTYPES[kind]), (path, dataset.dtype)


def check_fill(dataset, text, path):
    fill = dataset.fillvalue
    if text == "NaN":
        assert numpy.isnan(fill), path
    elif text == "empty":
        assert fill == b"", (path, fill)
    elif path.endswith("status"):
        assert fill == STATUSES.index(text), path
    elif path.endswith("method"):
        assert fill == METHODS.index(text), path
    elif path.endswith("order_reason"):
        assert fill == ORDER_REASONS.index(text), path
    elif path.endswith("split"):
        assert fill == SPLITS.index(text), path
    else:
        assert fill == int(text, 0), (path, fill)


def check_dataset(file, row, path, width, rows, samples, compression):
    _, link, kind, shape, fill, unit, meaning = row
    dataset = file[path]
    assert dataset.shape == expected_shape(shape, rows, samples, width), (path, dataset.shape)
    check_type(dataset, kind, path)
    check_fill(dataset, fill, path)
    assert dataset.fletcher32, path
    assert dataset.shuffle == (compression == "standard"), path
    assert (dataset.compression, dataset.compression_opts) == (
        ("gzip", 1) if compression == "standard" else (None, None)), path
    if link:
        assert file[link] == dataset, path
    if not path.startswith("/descriptors/"):
        assert dataset.attrs["description"] == meaning, path
        assert dataset.attrs.get("unit", "") == unit, path


def check_rows(file, lines, samples):
    ids = file["items/id"].asstr("utf-8")[:]
    reasons = file["items/reason"].asstr("utf-8")[:]
    points, descriptor = file["points"][:], file["descriptors/d2"][:]
    for i, line in enumerate(lines):
        name, status, label, split, size, repairs, coordinate, value = line.split()
        assert ids[i] == name
        assert file["items/status"][i] == int(status)
        assert file["label"][i, 0] == int(label)
        assert file["items/split"][i] == int(split)
        assert file["items/file_bytes"][i] == int(size)
        assert file["items/repairs"][i, 3] == int(repairs)
        if status == "0":
            assert reasons[i] == ""
            assert points[i, -1, -1] == numpy.float32(coordinate)
            assert descriptor[i, -1] == numpy.float32(value)
            assert sorted(file["curve_rank"][i]) == list(range(samples))
        else:
            assert reasons[i] == "row %d is %s" % (i, STATUSES[int(status)])
            for path in ("points", "normals", "barycentric", "density", "descriptors/d2", "descriptors/a3"):
                assert numpy.isnan(file[path][i]).all(), path
            for path in ("face_index", "corners", "curve_rank"):
                assert (file[path][i] == 0xFFFFFFFF).all(), path
            assert file["items/points_crc32c"][i] == 0


def check_attributes(file, rows, samples, compression):
    attributes = dict(file.attrs)
    assert attributes.pop("tool_version").count(".") == 2
    assert attributes == {"format": "meander", "format_version": 6, "method_version": 19, "content": "meshes", "seed": 7, "samples": samples,
                          "rows": rows, "compression": compression,
                          "parameters": '{"density":"uniform","describe":["d2"],"method":"conformal"}'}, attributes
    assert file["points"].attrs["order"] == "progressive"
    assert list(file["label"].attrs["names"]) == ["airplane", "chair", "\u00e9tag\u00e8re"]
    assert file["items/repairs"].attrs["names"][0] == "missing_vertices"
    assert len(file["items/repairs"].attrs["names"]) == file["items/repairs"].shape[1]
    assert dict(file["descriptors/d2"].attrs) == {"bins": "64 equal bins of [0, 2]", "scale": "mean distance is 1"}


def check_store(maker, page, rows, samples, compression):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "store.h5")
        lines = subprocess.run([maker, path, str(rows), str(samples), compression], check=True, text=True,
                               stdout=subprocess.PIPE).stdout.splitlines()
        assert len(lines) == rows
        with h5py.File(path, "r") as file:
            assert file.userblock_size == 512
            check_attributes(file, rows, samples, compression)
            names = []
            for row in layout_table(page):
                if row[0] == "/descriptors/<name>":
                    for name, width in DESCRIPTORS.items():
                        names.append("/descriptors/" + name)
                        check_dataset(file, row, names[-1], width, rows, samples, compression)
                    continue
                if row[0].startswith("/tensor/") and file.attrs["content"] != "anisotropic meshes":
                    assert "tensor" not in file
                    continue
                chosen = ("/rgb", "/texcoord", "/items/lacks", "/items/missing", "/items/names_bytes", "/names",
                          "/items/sign_rule", "/items/uncertain")
                if row[0] in chosen or row[0].startswith(("/items/color_", "/items/sharp_", "/attributes/", "/sharp/",
                                                          "/queries/")):
                    assert row[0] not in file
                    assert not {"attributes", "sharp", "queries"} & set(file)
                    continue
                width = file[row[0]].shape[-1]
                names += [row[0]] + ([row[1]] if row[1] else [])
                check_dataset(file, row, row[0], width, rows, samples, compression)
            found = []
            for group in ("/", "/items", "/descriptors"):
                found += [group.rstrip("/") + "/" + name for name in file[group]
                          if isinstance(file[group][name], h5py.Dataset)]
            assert sorted(found) == sorted(names), set(found) ^ set(names)
            check_rows(file, lines, samples)


if __name__ == "__main__":
    for case in [(50, 7, "standard"), (50, 7, "none"), (20, 2048, "standard"), (3, 100000, "none"), (1, 1, "standard")]:
        check_store(sys.argv[1], sys.argv[2], *case)
