#!/usr/bin/env python3
"""docs/load_store.py and docs/search_vectors.py on a real store, and every file of descriptors and arrays against numpy.

    load_store_test.py MEANDER DOCS       exit status 77: h5py is not installed
"""
import csv
import io
import json
import multiprocessing
import pickle
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

try:
    import h5py
    import numpy
except ImportError:
    print("skipped: h5py is not installed")
    sys.exit(77)


def write_box(path, x, y, z):
    corners = [(a, b, c) for a in (0, x) for b in (0, y) for c in (0, z)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    path.write_text("\n".join(["OFF", "8 6 0"] + [f"{a} {b} {c}" for a, b, c in corners]
                              + ["4 %d %d %d %d" % face for face in faces]) + "\n")


def check_loading(load_store, store):
    points, labels, ids, d2 = load_store.load_store(store, "d2")
    assert points.shape == (40, 128, 3) and numpy.isfinite(points).all()
    assert sorted(set(labels.tolist())) == [0, 2]  # "in" is that of the broken file
    assert ids[0] == "flat/box00.off"
    assert d2.shape == (40, 32) and numpy.allclose(d2.sum(axis=1), 1, atol=1e-5)

    dataset = load_store.StoreDataset(store, samples=32)
    assert len(dataset) == 40
    first = dataset[0]  # open in this process before the fork
    assert first[0].shape == (32, 3) and first[1].shape == (32, 3)
    for method in ("fork", "spawn"):
        with multiprocessing.get_context(method).Pool(2) as pool:
            items = pool.map(dataset.__getitem__, range(40))
        for index, (some_points, _, label) in enumerate(items):
            assert (some_points == points[index, :32]).all() and label == labels[index]
    assert len(load_store.StoreDataset(store, split="test")) == 0
    assert len(load_store.load_store(store, split="train")[2]) == 0
    assert (pickle.loads(pickle.dumps(dataset))[39][0] == points[39, :32]).all()


def every_value(group, found):
    """Arrays by the path of their dataset, of a store or an index of packs."""
    def take(path, dataset):
        if isinstance(dataset, h5py.Dataset) and not path.startswith("packs/"):
            found[path] = dataset[:]
    group.visititems(take)
    return found


def check_packs(meander, load_store, folder):
    """More rows than a pack has, through the commands: the index reads as the store of one process does."""
    (folder / "many").mkdir()
    for i in range(4100):
        write_box(folder / "many" / f"{i:04}.off", 1, 1 + i % 7, 2)
    sampling = ["--method", "direct", "-n", "4", "--progress", "none"]

    def run(*words):
        subprocess.run([Path(meander).resolve(), *map(str, words)], check=True, cwd=folder, stdout=subprocess.DEVNULL)
    run("run", "many", "-o", "one.h5", *sampling)
    run("plan", "many", "-o", "50%b.h5", "--shards", "3", *sampling[:-2])
    for shard in range(3):
        run("run", "50%b.h5.run", "--shard", f"{shard}/3", "--progress", "none")
    run("merge", "50%b.h5.run", "--pack-size", "1K")
    run("verify", "50%b.h5")
    packs = [folder / f"50%b.pack-0000{p}.h5" for p in (0, 1)]
    assert all(pack.exists() for pack in packs)
    with h5py.File(folder / "one.h5") as one, load_store.open_store(folder / "50%b.h5") as index:
        assert list(index["packs/rows"][:]) == [4096, 4]
        ours, theirs = every_value(index, {}), every_value(one, {})
        assert ours.keys() == theirs.keys() and len(ours) > 20
        for path, values in theirs.items():
            same = ours[path].dtype.kind == "S" or ours[path].dtype == values.dtype
            assert same and numpy.array_equal(ours[path], values, equal_nan=values.dtype.kind == "f"), path
    assert len(load_store.StoreDataset(folder / "50%b.h5")) == 4100
    packs[1].unlink()
    try:
        load_store.open_store(folder / "50%b.h5")
        raise AssertionError("a store without one of its packs was opened")
    except FileNotFoundError as error:
        assert "pack-00001" in str(error)


def check_ann(meander, store, file, distance, name):
    subprocess.run([meander, "export", str(store), "--descriptors", "d2+a3", "--format", "ann-hdf5", "-o", str(file),
                    "--queries", "7", "--neighbours", "5", "--distance", distance], check=True)
    with h5py.File(file) as ann:
        train, test = ann["train"][:], ann["test"][:]
        neighbors, distances = ann["neighbors"][:], ann["distances"][:]
        assert ann.attrs["distance"] == name
    assert train.shape == (33, 64) and test.shape == (7, 64) and train.dtype == test.dtype == numpy.float32
    assert neighbors.shape == distances.shape == (7, 5) and neighbors.dtype == numpy.int32
    if distance == "l2":
        expected = numpy.linalg.norm(test[:, None].astype(float) - train[None], axis=2)
    else:
        a, b = (x / numpy.linalg.norm(x.astype(float), axis=1, keepdims=True) for x in (test, train))
        expected = 1 - a @ b.T
    assert numpy.allclose(numpy.take_along_axis(expected, neighbors.astype(int), 1), distances, atol=2e-6)
    assert numpy.allclose(numpy.sort(expected, axis=1)[:, :5], distances, atol=2e-6)
    with h5py.File(store) as original, open(str(file) + ".ids.csv") as lines:
        both = numpy.hstack([original["descriptors/d2"][:], original["descriptors/a3"][:]])
        ids = original["items/id"].asstr()[:]
        counts = {"train": 0, "test": 0}
        for line in csv.DictReader(lines):
            part = {"train": train, "test": test}[line["part"]]
            assert int(line["position"]) == counts[line["part"]]
            assert (part[int(line["position"])] == both[int(line["row"])]).all()
            assert ids[int(line["row"])] == line["id"]
            counts[line["part"]] += 1
        assert counts == {"train": 33, "test": 7}


def check_vectors(meander, search_vectors, store, folder):
    """fbin, npy and CSV hold the values of the store, and l1 between weighted vectors is the combined distance."""
    with h5py.File(store) as original:
        ok = original["items/status"][:] == 0
        both = numpy.hstack([original["descriptors/d2"][:], original["descriptors/a3"][:]])[ok]
        ids = original["items/id"].asstr()[:][ok].tolist()
    for form in ("fbin", "npy"):
        for terms in ("d2+a3", "d2=2+a3"):
            file = str(folder / f"{terms}.{form}")
            subprocess.run([meander, "export", str(store), "--descriptors", terms, "--format", form, "-o", file],
                           check=True)
            vectors, listed = search_vectors.read_vectors(file)
            assert vectors.shape == both.shape and vectors.dtype == numpy.float32 and listed == ids
            assert terms != "d2+a3" or (vectors == both).all()
        found = json.loads(subprocess.run([meander, "retrieve", "query", str(store), ids[3], "--descriptor", "d2=2+a3",
                                           "-k", "6", "--json"], check=True, capture_output=True).stdout)["results"]
        order, distances = search_vectors.nearest(vectors, vectors[3], 7, block=16)
        assert order[0] == 3 and distances[0] == 0
        assert numpy.allclose(distances[1:], [row["distance"] for row in found], rtol=1e-4)
        assert {ids[i] for i in order[1:]} == {row["id"] for row in found}
    subprocess.run([meander, "export", str(store), "--descriptors", "d2+a3", "--format", "csv", "-o",
                    str(folder / "v.csv")], check=True)
    with open(folder / "v.csv", encoding="utf-8", newline="") as lines:
        rows = list(csv.reader(lines))
    assert rows[0][:3] == ["id", "label", "d2_b0"] and [row[0] for row in rows[1:]] == ids
    assert (numpy.array([row[2:] for row in rows[1:]], dtype=numpy.float32) == both).all()


DATASETS = {"points": "points", "normals": "normals", "face_index": "face_index", "corners": "corners",
            "barycentric": "barycentric", "curve_rank": "curve_rank", "density": "density", "rgb": "rgb"}
CHOSEN = {"texcoord": "texcoord", "attribute:height": "attributes/height", "attribute:place": "attributes/place"}


def check_equal(arrays, original, row):
    """Arrays by name are those of a row, in type and shape too."""
    for name, array in arrays.items():
        if name == "points_rgb":
            expected = numpy.hstack([original["points"][row], original["rgb"][row].astype(numpy.float32) / 255])
        else:
            expected = original[DATASETS[name]][row]
        assert array.dtype == expected.dtype and array.shape == expected.shape, (name, array.dtype, array.shape)
        assert (array == expected).all(), name


def check_arrays(meander, store, folder):
    """npz files and WebDataset shards hold the values of the store."""
    export = [meander, "export", str(store), "-o"]
    subprocess.run([*export, str(folder / "npz"), "--format", "npz", "--arrays", ",".join(sorted(DATASETS))], check=True)
    subprocess.run([*export, str(folder / "default"), "--format", "npz", "flat/box00.off"], check=True)
    with numpy.load(folder / "default" / "flat" / "box00.off.npz") as made:
        assert sorted(made.files) == ["frame", "loc", "normals", "points", "rgb", "scale"]
    subprocess.run([*export, str(folder / "shards"), "--format", "webdataset", "--arrays", "points_rgb,normals",
                    "--shard-bytes", "30k"], check=True)
    found = {}
    shards = sorted((folder / "shards").iterdir())
    assert [shard.name for shard in shards] == [f"c-{k:06}.tar" for k in range(len(shards))] and len(shards) > 5
    for shard in shards:
        assert shard.stat().st_size <= 30 * 1024
        with tarfile.open(shard) as tar:
            for member in tar:
                key, _, name = member.name.partition(".")
                found.setdefault(key, {})[name] = tar.extractfile(member).read()
    with h5py.File(store) as original:
        ids = original["items/id"].asstr()[:]
        ok = [row for row in range(len(ids)) if original["items/status"][row] == 0]
        assert sorted(found) == [f"{row:08}" for row in ok] and len(ok) == 40
        assert len(list((folder / "npz").rglob("*.npz"))) == len(ok)
        for row in ok:
            with numpy.load(folder / "npz" / (ids[row] + ".npz")) as made:
                arrays = dict(made)
            assert (arrays.pop("loc") == original["items/loc"][row]).all()
            scale = arrays.pop("scale")
            assert scale.shape == () and scale == original["items/scale"][row]
            assert arrays.pop("frame") == "stored"
            assert sorted(arrays) == sorted(DATASETS)
            check_equal(arrays, original, row)
            members = found[f"{row:08}"]
            assert sorted(members) == ["cls", "json", "normals.npy", "points_rgb.npy"]
            check_equal({name[:-4]: numpy.load(io.BytesIO(members[name])) for name in members if name.endswith("npy")},
                        original, row)
            about = json.loads(members["json"])
            assert about["id"] == ids[row] and about["row"] == row
            assert int(members["cls"]) == original["label"][row]
            assert about["class"] == ids[row].split("/")[0] and "split" not in about
            assert about["area"] == original["items/area"][row]
            assert about["frame"] == "stored" and about["scale"] == original["items/scale"][row]


def read_members(folder):
    """Of the shards of a folder: key: {name: bytes}."""
    found = {}
    for shard in sorted(folder.glob("*.tar")):
        with tarfile.open(shard) as tar:
            for member in tar:
                key, _, name = member.name.partition(".")
                found.setdefault(key, {})[name] = tar.extractfile(member).read()
    return found


def check_frames(meander, folder):
    """Every format in either frame has the values that it says, for numpy and h5py."""
    store = folder / "framed.h5"
    subprocess.run([meander, "run", str(folder / "in"), "-o", str(store), "-n", "128", "--normalize", "pointnet",
                    "--colors", "--label-from-folder", "--progress", "none"], check=False)
    with h5py.File(store) as file:
        ids = file["items/id"].asstr()[:].tolist()
        ok = [row for row in range(len(ids)) if file["items/status"][row] == 0]
        stored, loc, scale = file["points"][:], file["items/loc"][:], file["items/scale"][:]
        rgb, labels = file["rgb"][:], file["label"][:, 0]
    assert len(ok) == 40
    assert numpy.abs(stored[ok].mean(axis=1, dtype=float)).max() < 1e-7
    assert numpy.allclose(numpy.linalg.norm(stored[ok], axis=2).max(axis=1), 1, atol=2e-7)
    of_file = loc[:, None] + scale[:, None, None] * stored.astype(float)

    def expected(frame, rows):
        return (of_file if frame == "file" else stored)[rows]
    for frame in ("stored", "file"):
        def export(form, *words):
            out = folder / f"{form}-{frame}"
            subprocess.run([meander, "export", str(store), "-o", str(out), "--frame", frame, *words], check=True,
                           stdout=subprocess.DEVNULL)
            return out
        number = numpy.float64 if frame == "file" else numpy.float32
        npz, shards = (export(form, "--format", form, "--arrays", "points,points_rgb") for form in ("npz", "webdataset"))
        members = read_members(shards)
        xyz = export("xyz", "--format", "xyz")
        for row in ok:
            both = numpy.hstack([expected(frame, row), rgb[row].astype(number) / 255])
            with numpy.load(npz / (ids[row] + ".npz")) as made:
                assert str(made["frame"]) == frame and (made["loc"] == loc[row]).all() and made["scale"] == scale[row]
                assert made["points"].dtype == number and (made["points"] == expected(frame, row)).all()
                assert made["points_rgb"].dtype == number and (made["points_rgb"] == both).all()
            of_row = members[f"{row:08}"]
            about = json.loads(of_row["json"])
            assert about["frame"] == frame and about["loc"] == loc[row].tolist() and about["scale"] == scale[row]
            assert (numpy.load(io.BytesIO(of_row["points.npy"])) == expected(frame, row)).all()
            assert (numpy.load(io.BytesIO(of_row["points_rgb.npy"])) == both).all()
            text = numpy.loadtxt(xyz / (ids[row] + ".xyz"))  # which takes the last line for a comment
            assert text.shape == (128, 6) and (text[:, :3].astype(number) == expected(frame, row)).all()
        pointnet = export("pointnet", "--pointnet")
        with h5py.File(pointnet / "ply_data_train0.h5") as shard:
            listed = json.loads((pointnet / "ply_data_train_0_id2file.json").read_text())
            rows = [ids.index(item) for item in listed]
            assert shard["data"].attrs["frame"] == frame and shard["data"].dtype == number
            assert (shard["data"][:] == expected(frame, rows)).all()
            assert (shard["label"][:, 0] == labels[rows]).all()


def write_numbered_box(path):
    corners = [(a, b, c) for a in (0, 1) for b in (0, 1) for c in (0, 2)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    names = ("x", "y", "z", "height", "place_0", "place_1")
    path.write_text("\n".join(["ply", "format ascii 1.0", "element vertex 8"]
                              + [f"property float {name}" for name in names]
                              + ["element face 6", "property list uchar int vertex_indices", "end_header"]
                              + [f"{a} {b} {c} {c} {a} {b}" for a, b, c in corners]
                              + ["4 %d %d %d %d" % face for face in faces]) + "\n")


def check_chosen(load_store, meander, folder):
    """Attributes and texture coordinates by h5py and as npz, and a store without normals."""
    (folder / "chosen").mkdir()
    write_numbered_box(folder / "chosen" / "a.ply")
    store = folder / "chosen.h5"
    subprocess.run([meander, "run", str(folder / "chosen"), "-o", str(store), "-n", "64", "--texcoord", "--attribute",
                    "height,place:2", "--store", "density", "--progress", "none"], check=True)
    with h5py.File(store) as file:
        assert file.attrs["format_version"] == 6 and "normals" not in file and "face_index" not in file and "face" not in file
        assert list(file.attrs["columns"]) == ["points", "density", "texcoord", "attributes/height", "attributes/place"]
        points = file["points"][0]
        assert numpy.allclose(file["attributes/height"][0], points[:, 2], atol=1e-6)
        assert numpy.allclose(file["attributes/place"][0], points[:, :2], atol=1e-6)
        assert numpy.isnan(file["texcoord"][0]).all()
        lacks = file["items/lacks"]
        assert lacks[0] == 4 and list(lacks.attrs["names"])[2] == "texcoord"
    subprocess.run([meander, "export", str(store), "-o", str(folder / "chosen-npz"), "--format", "npz", "--arrays",
                    ",".join(["points", *CHOSEN])], check=True)
    with numpy.load(folder / "chosen-npz" / "a.ply.npz") as made, h5py.File(store) as file:
        for name, dataset in CHOSEN.items():
            array = made[name.replace(":", "_")]
            assert array.dtype == numpy.float32
            assert numpy.array_equal(array, file[dataset][0], equal_nan=True), name
    assert load_store.load_store(store)[0].shape == (1, 64, 3)
    (folder / "parts").mkdir()
    for name, faces in ("a", "o seat\nf 1 2 3\no leg\nf 1 3 4\n"), ("b", "f 1 2 3 4\n"), ("c", "o c\nf 1 2 3 4\n"):
        (folder / "parts" / f"{name}.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" + faces)
    parts = folder / "parts.h5"
    subprocess.run([meander, "run", str(folder / "parts"), "-o", str(parts), "-n", "64", "--attribute", "object",
                    "--progress", "none"], check=True)
    with load_store.open_store(parts) as file:
        assert [load_store.names_of(file, row) for row in range(3)] == [{"object": ["seat", "leg"]}, {}, {"object": ["c"]}]
        assert file["attributes/object"].dtype == numpy.int32 and file["attributes/object"].fillvalue == -1
        assert (file["attributes/object"][0] == file["face_index"][0]).all() and (file["attributes/object"][1] == -1).all()
        assert list(file["items/missing"]) == [0, 1, 0]
    subprocess.run([meander, "export", str(parts), "-o", str(folder / "parts-npz"), "--format", "npz", "--arrays",
                    "attribute:object"], check=True)
    with numpy.load(folder / "parts-npz" / "a.obj.npz") as made:
        assert made["attribute_object"].dtype == numpy.int32
    with load_store.open_store(store) as file:
        assert load_store.names_of(file, 0) == {}
    try:
        load_store.StoreDataset(store)
        raise AssertionError("a data set of normals that are not there")
    except ValueError as error:
        assert "no normals" in str(error)


def write_colored_box(path, height):
    corners = [(a, b, c) for a in (0, 1) for b in (0, 1) for c in (0, height)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    path.write_text("\n".join(["COFF", "8 6 0"] + [f"{a} {b} {c} {60 * a} {255 * b} {30} 255" for a, b, c in corners]
                              + ["4 %d %d %d %d" % face for face in faces]) + "\n")


def main():
    meander = sys.argv[1]
    sys.path.insert(0, sys.argv[2])
    sys.dont_write_bytecode = True
    import load_store
    import search_vectors
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for name, height in (("flat", 0.1), ("tall", 3)):
            (folder / "in" / name).mkdir(parents=True)
            for i in range(20):
                write_box(folder / "in" / name / f"box{i:02}.off", 1, 1 + 0.1 * i, height)
        (folder / "in" / "broken.off").write_text("OFF\n3 1 0\n0 0\n")
        store = folder / "s.h5"
        made = subprocess.run([meander, "run", str(folder / "in"), "-o", str(store), "-n", "128", "--method", "direct",
                               "--label-from-folder", "--progress", "none"], check=False)
        assert made.returncode == 3  # the broken file
        subprocess.run([meander, "describe", str(store), "--descriptors", "d2,a3", "--progress", "none"], check=True)
        check_loading(load_store, store)
        check_vectors(meander, search_vectors, store, folder)
        check_ann(meander, store, folder / "l2.hdf5", "l2", "euclidean")
        check_ann(meander, store, folder / "cosine.hdf5", "cosine", "angular")
        for i in range(20):
            for name, height in (("flat", 0.1), ("tall", 3)):
                write_colored_box(folder / "in" / name / f"box{i:02}.off", height + 0.1 * i)
        colored = folder / "c.h5"
        made = subprocess.run([meander, "run", str(folder / "in"), "-o", str(colored), "-n", "128", "--colors",
                               "--label-from-folder", "--progress", "none"], check=False)
        assert made.returncode == 3
        check_arrays(meander, colored, folder)
        check_frames(meander, folder)
        check_packs(meander, load_store, folder)
        check_chosen(load_store, meander, folder)
    print("numpy, data set and files of descriptors are as the store says")


if __name__ == "__main__":
    main()
