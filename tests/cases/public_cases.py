"""Runs small files of the kinds that public reports, format pages and data sets tell of, and checks the store:
area, box, colors, labels and statuses.

usage: public_cases.py MEANDER [--keep FOLDER] [--list] [NAME ...]
--list prints the table of cases as Markdown, --keep leaves the files in FOLDER. NAME runs these cases only.
Every input is made here; `where` names what told of the kind. Exit code 77 (skipped) without numpy or h5py.
"""
import argparse
import collections
import gzip
import os
import struct
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy
except ImportError:
    sys.exit(77)

from small_models import (HALVES, OBJ_COORDINATES, OBJ_VERTICES, SQUARE, XYZ, Gltf, ascii_stl, binary_stl, obj, off,
                          plain_png, ply, png, rows, square_ply, textured, two_png, zipped)

RED, GREEN, BLUE, FILL = (255, 0, 0), (0, 255, 0), (0, 0, 255), (204, 204, 204)
SQUARE_BOX = (0, 0, 0, 1, 1, 0)
SAMPLES = 256

Case = collections.namedtuple("Case", "name where subject files rows options code says", defaults=((), None, ""))
CASES = []


def case(name, where, subject, files, expected, options=(), code=None, says=""):
    """expected: by path below the case's folder; or one result for all its models.
    options: a run of its own with these. code, says: its exit code, and words on its standard error or output."""
    if "status" in expected:
        models = (".off", ".obj", ".ply", ".stl", ".gltf", ".glb")
        expected = {path: expected for path in files if path.lower().endswith(models)}
    CASES.append(Case(name, where, subject, files, expected, options, code, says))


def ok(area=1.0, box=SQUARE_BOX, **more):
    """rgb: the color of every sample; repairs: counts by name; label: name of the class."""
    return dict(status="ok", area=area, box=box, **more)


def fails(status, reason=""):
    return dict(status=status, reason=reason)


# ---- PLY -------------------------------------------------------------------------------------------------------------

def packed(code, order="<"):
    return lambda t: struct.pack(order + code, 3, *t)


case("ply_index_real", "Turk, The PLY Polygon File Format: any numerical type in a list",
     "vertex numbers that are stored as float or double",
     {"binary_float.ply": square_ply("property list uchar float vertex_indices", packed("B3f"), "binary_little_endian"),
      "binary_double.ply": square_ply("property list int double vertex_index", packed("i3d"), "binary_little_endian"),
      "text.ply": square_ply("property list uchar float vertex_indices", lambda t: (3, *map(float, t))),
      "exponents.ply": square_ply("property list uchar double vertex_indices", lambda t: (
          3, *(f"{c:.18e}" for c in t)))}, ok())
case("ply_length_real", "Turk, The PLY Polygon File Format: any numerical type in a list",
     "the length of a list is stored as float or double",
     {"float.ply": square_ply("property list float int vertex_indices", packed("f3i"), "binary_little_endian"),
      "double.ply": square_ply("property list double uint vertex_indices", packed("d3I", ">"), "binary_big_endian"),
      "text.ply": square_ply("property list float int vertex_indices", lambda t: ("3.0", *t))}, ok())
case("ply_long_integers", "unibas-gravis/scalismo-faces PR 41; ddiakopoulos/tinyply 70",
     "64-bit integers: int64 and uint64",
     {"int64.ply": square_ply("property list uint8 int64 vertex_indices", packed("B3q"), "binary_little_endian"),
      "uint64.ply": square_ply("property list uint64 uint64 vertex_indices", packed("Q3Q", ">"), "binary_big_endian"),
      "text.ply": square_ply("property list uchar int64 vertex_indices")}, ok())
case("ply_length_types", "cnr-isti-vclab/meshlab 290; nmwsharp/happly 4", "lists whose length is ushort, uint or char",
     {"ushort.ply": square_ply("property list ushort uint vertex_indices", packed("H3I"), "binary_little_endian"),
      "uint.ply": square_ply("property list uint uint vertex_indices", packed("I3I"), "binary_little_endian"),
      "char.ply": square_ply("property list char short vertex_index", packed("b3h", ">"), "binary_big_endian")}, ok())
case("ply_faces_first", "Turk, The PLY Polygon File Format: elements in the order of the header",
     "faces before vertices",
     {"text.ply": ply(["element face 2", "property list uchar int vertex_indices", "element vertex 4", *XYZ],
                      rows((3, *t) for t in HALVES) + rows(SQUARE)),
      "binary.ply": ply(["element face 2", "property list uchar int vertex_indices", "element vertex 4", *XYZ],
                        b"".join(packed("B3i")(t) for t in HALVES) + b"".join(struct.pack("<3f", *v) for v in SQUARE),
                        "binary_little_endian")}, ok())
case("ply_odd_comments", "Stanford 3D Scanning Repository headers", "obj_info, and comments that read as header lines",
     {"a.ply": square_ply(comments=("obj_info num_cols 512", "comment end_header", "comment", "comment element face 7",
                                    "comment property float w", "comment Gr\u00fc\u00dfe"))}, ok())
case("ply_strips", "vilya/miniply 1; assimp/assimp 6296", "triangle strips that -1 begins anew",
     {"a.ply": ply(["element vertex 4", *XYZ, "element tristrips 1", "property list int int vertex_indices"],
                   rows(SQUARE) + "8 0 1 2 -1 0 2 3 -1\n")}, ok())
case("ply_points_alone", "PointCloudLibrary/pcl 968", "`element face 0`, and no faces at all",
     {"zero.ply": ply(["element vertex 4", *XYZ, "element face 0", "property list uchar int vertex_indices"],
      rows(SQUARE)),
      "none.ply": ply(["element vertex 4", *XYZ], rows(SQUARE))}, fails("empty", "4 vertices"))
case("ply_lf_cr", "mrdoob/three.js 26229", "header lines that end in LF CR, before binary rows",
     {"a.ply": square_ply(encoding="binary_little_endian", end="\n\r"),
      "b.ply": square_ply(encoding="binary_big_endian", end="\n\r")}, ok())
case("ply_line_ends", "mrdoob/three.js PR 24264 and 14937; isl-org/Open3D 5091", "CR alone, and CRLF",
     {"cr.ply": square_ply(end="\r"), "crlf.ply": square_ply(end="\r\n"),
      "cr_binary.ply": square_ply(encoding="binary_little_endian", end="\r"),
      "crlf_binary.ply": square_ply(encoding="binary_little_endian", end="\r\n")}, ok())
case("ply_first_byte_is_a_line_end", "mrdoob/three.js PR 26232", "binary rows whose first byte is a line end",
     {"a.ply": ply(["element vertex 4", "property uchar tag", *XYZ, "element face 2",
      "property list uchar int vertex_indices"],
                   b"".join(b"\r" + struct.pack("<3f",
                   *v) for v in SQUARE) + b"".join(packed("B3i")(t) for t in HALVES),
                   "binary_little_endian"),
      "b.ply": ply(["element vertex 4", "property uchar tag", *XYZ, "element face 2",
      "property list uchar int vertex_indices"],
                   b"".join(b"\n" + struct.pack("<3f",
                   *v) for v in SQUARE) + b"".join(packed("B3i")(t) for t in HALVES),
                   "binary_little_endian", end="\r\n")}, ok())
case("ply_lists_of_vertices", "CloudCompare/CloudCompare 1455", "a list among the properties of vertices",
     {"a.ply": ply(["element vertex 4", "property list uint float64 descriptor", *XYZ, "element face 2",
                    "property list uchar int vertex_indices"],
                   b"".join(struct.pack("<I", k) + struct.pack(f"<{k}d", *[7.0] * k) + struct.pack("<3f", *v)
                            for k, v in enumerate(SQUARE)) + b"".join(packed("B3i")(t) for t in HALVES),
                   "binary_little_endian")}, ok())
case("ply_short_faces", "assimp/assimp PR 2863", "faces of 0, 1 and 2 corners among others",
     {"a.ply": ply(["element vertex 4", *XYZ, "element face 5", "property list uchar int vertex_indices"],
                   rows(SQUARE) + "0\n3 0 1 2\n1 3\n2 0 1\n3 0 2 3\n")}, ok(repairs={"short_faces": 3}))
case("ply_blank_lines", "mrdoob/three.js PR 18054", "blank lines in the header and between vertices and faces",
     {"a.ply": ply(["element vertex 4", *XYZ, "", "element face 2", "property list uchar int vertex_indices"],
                   rows(SQUARE) + "\n" + rows((3, *t) for t in HALVES) + "\n")}, ok())
case("ply_colors_of_both", "PyMesh/PyMesh 13",
     "vertices and faces have properties of the same names, alpha and texcoord among them",
     {"a.ply": ply(["element vertex 4", *XYZ, *(f"property uint8 {c}" for c in ("red", "green", "blue", "alpha")),
                    "element face 2", "property list uint8 int32 vertex_indices",
                    "property list uint8 float32 texcoord",
                    *(f"property uint8 {c}" for c in ("red", "green", "blue", "alpha"))],
                   rows((*v, 255, 0, 0, 0) for v in SQUARE) + rows((3, *t, 6, 0, 0, 1, 0, 1, 1, 0, 0, 255,
                   0) for t in HALVES))},
     ok(rgb=RED))
case("ply_material_table", "Turk, The PLY Polygon File Format: element material, material_index of faces",
     "colors of faces in an element of materials",
     {"a.ply": ply(["element vertex 4", *XYZ, "element face 2", "property list uchar int vertex_indices",
                    "property int material_index", "element material 2",
                    *(f"property uchar {kind}_{c}" for kind in ("ambient", "diffuse") for c in ("red", "green",
                    "blue"))],
                   rows(SQUARE) + "3 0 1 2 1\n3 0 2 3 1\n" + "0 0 0 0 0 255\n0 0 0 255 0 0\n")}, ok(rgb=RED))
case("ply_upper_case", "qgis/QGIS 52467; PDAL/PDAL 1570", "X, Y and Z in capitals",
     {"a.ply": ply(["element vertex 4", "property float X", "property float Y", "property float Z", "element face 2",
                    "property list uchar int vertex_indices"], rows(SQUARE) + rows((3, *t) for t in HALVES))}, ok())
case("ply_edges_between", "cnr-isti-vclab/meshlab 810", "an element of edges between vertices and faces",
     {"a.ply": ply(["element vertex 4", *XYZ, "element edge 2", "property uint vertex1", "property uint vertex2",
                    "element face 2", "property list uchar int vertex_indices"],
                   rows(SQUARE) + "0 1\n1 2\n" + rows((3, *t) for t in HALVES))}, ok())
case("ply_order_of_properties", "mikedh/trimesh 374; playcanvas/react 198",
     "double coordinates in another order, big-endian",
     {"a.ply": ply(["element vertex 4", "property double z", "property uchar flag", "property double x",
      "property double y",
                    "element face 2", "property list uchar int vertex_indices"],
                   b"".join(struct.pack(">dB2d", v[2], 9, v[0], v[1]) for v in SQUARE) +
                   b"".join(packed("B3i", ">")(t) for t in HALVES), "binary_big_endian")}, ok())
case("ply_padded_corners", "assimp and VCG writers of mixed polygons", "a corner of -1 fills the place of a fourth",
     {"a.ply": ply(["element vertex 4", *XYZ, "element face 3", "property list uchar int vertex_indices"],
                   rows(SQUARE) + "3 0 1 2\n3 0 2 3\n4 0 1 2 -1\n")}, ok(repairs={"index_out_of_range": 1}))
case("ply_rows_over_lines", "mrdoob/three.js PR 25796: files of librealsense",
     "a vertex whose normal stands on the next line",
     {"a.ply": ply(["element vertex 4", *XYZ, "property float nx", "property float ny", "property float nz",
      "element face 2",
                    "property list uchar int vertex_indices"],
                   "".join(f"{x} {y} {z} \n0 0 1 \n" for x, y, z in SQUARE) + rows((3, *t) for t in HALVES))}, ok())
case("ply_int_length", "niessner/mLib PR 15: output of the Surface Trimmer", "the length of a face is an int",
     {"a.ply": square_ply("property list int int vertex_indices", packed("i3i"), "binary_little_endian")}, ok())
case("ply_byte_order_mark", "MeshInspector/MeshLib PR 5653", "a byte-order mark before `ply`",
     {"a.ply": b"\xef\xbb\xbf" + square_ply()}, ok())

# ---- OFF -------------------------------------------------------------------------------------------------------------

case("off_comments_between", "mikedh/trimesh 542; tumcms/Open-Infra-Platform 382",
     "comments and blank lines between rows and behind numbers",
     {"a.off": b"# made by hand\nOFF # the keyword\n\n# counts\n4 2 0 # of them\n\n0 0 0 # first\n# between\n1 0 0\n"
               b"1 1 0\n\n0 1 0\n"
               b"#faces\n3 0 1 2 # red\n\n3 0 2 3 # green"}, ok())
case("off_counts_with_keyword", "fougue/mayo 258; mikedh/trimesh PR 753",
     "counts behind the keyword, with and without a blank",
     {"a.off": off("OFF 4 2 0", ""), "b.off": off("OFF4 2 0", ""), "c.off": off("OFF  4 2", ""),
      "d.off": off("OFF\n\n4\n2", "0"),
      "e.off": off("COFF4 2 0", "", [(*v, 1, 0, 0, 1) for v in SQUARE])}, ok())
case("off_no_edges", "Princeton, OFF file format: the number of edges can be ignored", "two counts",
     {"a.off": off(counts="4 2")}, ok())
case("off_dimensions", "Geomview, OFF: nOFF and 4nOFF", "vertices of a stated number of dimensions",
     {"n3.off": off("nOFF", "3\n4 2 0"), "n3_line.off": off("nOFF 3", "4 2 0"),
      "n2.off": off("nOFF", "2\n4 2 0", [v[:2] for v in SQUARE]),
      "h3.off": off("4nOFF", "3\n4 2 0", [(2 * x, 2 * y, 2 * z, 2) for x, y, z in SQUARE]),
      "cn3.off": off("CnOFF", "3\n4 2 0", [(*v, 1, 0, 0, 1) for v in SQUARE])},
     {**{name: ok() for name in ("n3.off", "n3_line.off", "n2.off", "h3.off")}, "cn3.off": ok(rgb=RED)})
case("off_more_dimensions", "Geomview, OFF: nOFF and 4nOFF", "vertices of four dimensions are not read as three",
     {"n4.off": off("nOFF", "4\n4 2 0", [(*v, 5) for v in SQUARE])}, fails("unsupported_format", "dimensions"))
case("off_all_prefixes", "Geomview, OFF: [ST][C][N][4]OFF",
     "homogeneous vertices with normal, color and texture coordinate",
     {"stcn4.off": off("STCN4OFF", vertices=[(2 * x, 2 * y, 2 * z, 2, 0, 0, 1, 1, 0, 0, 1, x, y) for x, y,
      z in SQUARE]),
      "cn.off": off("CNOFF", vertices=[(*v, 0, 0, 1, 1, 0, 0, 1) for v in SQUARE]),
      "stc.off": off("STCOFF", vertices=[(*v, 1, 0, 0, 1, v[0], v[1]) for v in SQUARE])}, ok(rgb=RED))
case("off_texture_alone", "Geomview, OFF: STOFF", "texture coordinates behind the vertices are no colors",
     {"st.off": off("STOFF", vertices=[(*v, 0.5, 0.25) for v in SQUARE]),
      "stn.off": off("STNOFF", vertices=[(*v, 0, 0, 1, 0.5, 0.25) for v in SQUARE])}, ok(rgb=FILL))
case("off_real_numbers", "numpy.savetxt writes every number by one format",
     "vertex numbers with a point or an exponent",
     {"point.off": off(faces=[(3, 0.0, 1.0, 2.0), (3, 0.0, 2.0, 3.0)]),
      "exponent.off": off(faces=[[f"{c:.18e}" for c in (3, *t)] for t in HALVES]),
      "counts.off": off(counts="4.0 2.0 0.0")}, {"point.off": ok(), "exponent.off": ok(),
      "counts.off": fails("unreadable", "not a number of vertices")})
case("off_half_numbers", "numpy.savetxt writes every number by one format", "a vertex number of 1.5 is none",
     {"a.off": off(faces=[(3, 0, 1.5, 2), (3, 0, 2, 3)])}, ok(0.5))
case("off_geomview_braces", "Geomview, OOGL files: objects in braces", "braces and an appearance around the object",
     {"braces.off": b"{ " + off() + b"}\n", "appearance.off": b"{ appearance { +edge } " + off() + b"}\n"},
     fails("unreadable", "neither OFF nor counts"))
case("off_free_rows", "AcademySoftwareFoundation/openvdb PR 1971", "vertices that are spread over lines",
     {"a.off": b"OFF\n4 2 0\n0 0\n0 1 0\n0 1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"}, ok())
case("off_line_ends", "files of old Macintosh programs", "CR alone, CRLF, a byte-order mark",
     {"cr.off": off().replace(b"\n", b"\r"), "crlf.off": off().replace(b"\n", b"\r\n"),
      "mark.off": b"\xef\xbb\xbf" + off(),
      "lower.off": off("off")}, ok())
case("off_binary", "Geomview, OFF BINARY: big-endian words, a count of color components behind each face",
     "binary rows, both byte orders",
     {name: b"OFF BINARY\n" + struct.pack(order + "3i", 4, 2, 0) + b"".join(struct.pack(order + "3f",
      *v) for v in SQUARE) +
      b"".join(struct.pack(order + "5i4f", 3, *t, 4, 1, 0, 0, 1) for t in HALVES)
      for name, order in (("big.off", ">"), ("little.off", "<"))}, ok(rgb=RED))
case("off_header_alone", "mikedh/trimesh PR 2591", "a keyword and nothing behind it",
     {"a.off": b"OFF\n", "b.off": b"OFF\n4\n"}, fails("unreadable", "ends before the number of"))

# ---- OBJ and MTL -----------------------------------------------------------------------------------------------------

case("obj_relative", "mikedh/trimesh 2364", "blocks of vertices and faces that count backwards",
     {"a.obj": b"o one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\no two\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf -3 -2 -1\n",
      "mixed.obj": obj("f -4//-1 2//1 3//1\nf 1 -2 -1\n", "vn 0 0 1\n")}, ok())
case("obj_blanks", "Famous/engine PR 161; strands-labs/robots PR 2659",
     "blanks at the ends of lines, tabs behind keywords",
     {"a.obj": b"v\t0\t0\t0  \n  v  1 0 0\t\nv 1 1 0 \n\tv 0 1 0\nf\t1  2   3  \t \n f 1 3 4\t\r\n"}, ok())
case("obj_slashes", "Ultimaker/Uranium PR 599; cnr-isti-vclab/nexus PR 128",
     "corners as a, a/b, a//c, a/b/c, a/ and a//",
     {"a.obj": obj("f 1 2/2 3//1\nf 1/1/1 3/ 4//\n", "vn 0 0 1\n")}, ok())
case("obj_zero", "tinyobjloader/tinyobjloader 140", "vertex numbers that begin at 0",
     {"a.obj": obj("f 0 1 2\nf 1 3 4\n")}, ok(0.5, repairs={"index_out_of_range": 1}))
case("obj_forward", "Wavefront, OBJ: vertices by number in the file", "faces before the vertices that they name",
     {"a.obj": b"f 1 2 3\nf 1 3 4\n" + OBJ_VERTICES.encode()}, ok())
case("obj_face_outlines", "Wavefront, Advanced Visualizer 2.11: `fo`, read as `f` since 3.0",
     "faces by the old keyword fo",
     {"a.obj": obj("fo 1 2 3\nfo 1/1 3/3 4/4\n"), "b.obj": obj("f 1 2 3\nfo 1 3 4\n")}, ok())
case("obj_lines_and_points", "thisistherk/fast_obj PR 54", "lines and points among faces",
     {"a.obj": obj("p 1 2\nl 1 2 3 4\nf 1 2 3\nl 4/4 1/1\np -1\nf 1 3 4\n")}, ok())
case("obj_free_form", "assimp/assimp 4406; Twinklebear/tobj 77",
     "curves and surfaces beside faces: the faces are sampled",
     {"a.obj": obj("f 1 2 3\nf 1 3 4\ncstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 4 3\nparm u 0 1\n"
                   "parm v 0 1\nend\ncurv 0 1 1 2\nend\n")},
     ok())
case("obj_weights", "Wavefront, OBJ: w is the weight of rational curves and surfaces",
     "a fourth number is no divisor of x y z",
     {"a.obj": obj("f 1 2 3\nf 1 3 4\n").replace(b"v 1 1 0", b"v 1 1 0 2").replace(b"v 0 0 0", b"v 0 0 0 1.0")}, ok())
case("obj_color_and_opacity", "cnr-isti-vclab/meshlab, OBJ with colors of vertices",
     "colors with an opacity behind them",
     {"a.obj": (rows(("v", *v, 1, 0, 0, 0.25) for v in SQUARE) + "f 1 2 3\nf 1 3 4\n").encode()}, ok(rgb=RED))
case("obj_continued", "Wavefront, OBJ: a backslash joins lines", "vertices and faces over several lines",
     {"a.obj": b"v 0 0 \\\n0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n# C:\\models\\\nf 1 \\\r\n2 \\  \n3\nf 1 3 4\n"}, ok())
case("obj_number_forms", "Wavefront exporters", "numbers as 1.0e+0, +1, 1., .0E-05, 0.1e1",
     {"a.obj": b"v 0.0e+5 .0E-05 -0\nv 1.0e+0 0 0\nv +1 1. 0e0\nv 0 0.1e1 0.\nf 1 2 3\nf 1 3 4\n"}, ok())
case("text_fortran_exponents", "gazebosim/sdformat 1578; JuliaData/Parsers.jl 199",
     "numbers of Fortran programs: 1.0D+00",
     {"a.obj": b"v 0.0D+00 0.0d0 0D0\nv 1.0D+00 0 0\nv 0.1d1 10.D-1 0\nv 0 1.0D0 0\nf 1 2 3\nf 1 3 4\n",
      "b.stl": ascii_stl(vertex="vertex {}.0D+00 {}.0D+00 {}.0D+00"),
      "c.off": off(vertices=[[f"{c}.0D+00" for c in v] for v in SQUARE]),
      "d.ply": square_ply(vertex_row=lambda v: [f"{c}.0d+00" for c in v])}, ok())
case("text_decimal_commas", "Dezinater/osrscachereader PR 16; exporters that follow the language of the system",
     "1,5 is never read as 1 or as 15",
     {"a.obj": b"v 0,0 0,0 0,0\nv 1,5 0,0 0,0\nv 1,0 1,0 0,0\nf 1 2 3\n",
      "b.stl": ascii_stl(vertex="vertex {},0 {},0 {},0"),
      "c.off": off(vertices=[[f"{c},5" for c in v] for v in SQUARE]),
      "d.ply": square_ply(vertex_row=lambda v: [f"{c},5" for c in v])}, fails("unreadable", "line "))
case("obj_real_indices", "nileshkulkarni/volumetricPrimitivesPytorch 7", "faces as 1.0 2.0 3.0",
     {"a.obj": obj("f 1.0 2.0 3.0\nf 1.0 3.0 4.0\n"),
      "b.obj": obj("f 1.000000e+00 2.000000e+00 3.000000e+00\nf 1 3 4\n")}, ok())
case("obj_comment_words", "mikedh/trimesh PR 1918", "comments that hold keywords, and text behind faces",
     {"a.obj": obj("# f 1 2 4\n#f 1 2 4\ng f\no v 1 2 3\nf 1 2 3 # f 4\nf 1 3 4#end\n")}, ok())
case("obj_unknown_words", "tinyobjloader/tinyobjloader test models", "smoothing, levels and words that no one knows",
     {"a.obj": obj("s off\nlod 1\nbevel on\nc_interp off\nshadow_obj x.obj\nfoo 1 2 3\nface 1 2 4\n"
                   "f 1 2 3\nvp 0 0\nf 1 3 4\n")}, ok())
case("obj_concave", "mikedh/trimesh, mapbox_earcut and n-gons of Blender",
     "a concave polygon of one face, not a fan over its outside",
     {"a.obj": b"v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf 1 2 3 4 5\n",
      "start.obj": b"v 2 1 0\nv 0 4 0\nv 0 0 0\nv 4 0 0\nv 4 4 0\nf 2 3 4 5 1\n"},
     ok(10, (0, 0, 0, 4, 4, 0)))
case("obj_line_ends", "files of old Macintosh programs", "CR alone, in OBJ and MTL",
     {"cr.obj": obj("usemtl m\rf 1/1 2/2 3/3\rf 1/1 3/3 4/4\r", "mtllib cr.mtl\r").replace(b"\n", b"\r"),
      "cr.mtl": b"newmtl a\rKd 0 0 1\rnewmtl m\rKd 1 0 0\r"}, ok(rgb=RED))

TEXTURE = {"tex.png": plain_png(255, 0, 0)}
case("mtl_options", "tinyobjloader/tinyobjloader 248; kovacsv/Online3DViewer 371",
     "-s, -o, -t, -mm, -bm, -clamp before the name, with one to three numbers",
     {**textured("newmtl m\nmap_Kd -s 1 1 1 -o 0 0 0 -t 0 0 0 -mm 0 1 -bm 1.0 -clamp on -blendu off tex.png\n"),
      **TEXTURE}, ok(rgb=RED))
case("mtl_scale_of_one_number", "Wavefront, MTL: -s u [v [w]]", "-s and -o with the first number alone",
     {**textured("newmtl m\nmap_Kd -s 2 -o 0 two.png\n", faces="f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"),
      "two.png": plain_png(0, 0, 255)}, ok(rgb=BLUE))
case("mtl_names_with_blanks", "javagl/Obj PR 28; tinyobjloader/tinyobjloader 49",
     "blanks in the names of images and libraries",
     {**textured("newmtl m\nmap_Kd my big tex.png\n", library="my model.mtl"), "my big tex.png": plain_png(255, 0, 0)},
      ok(rgb=RED))
case("mtl_names_in_utf8", "KhronosGroup/glTF-Sample-Models, Unicode test",
     "images, libraries and materials with letters beyond ASCII",
     {**textured("newmtl h\u00f6lzern\nmap_Kd \u6728\u76ee.png\n", "usemtl h\u00f6lzern\n", "m\u00f6bel.mtl"),
      "\u6728\u76ee.png": plain_png(255, 0, 0)}, ok(rgb=RED))
case("mtl_tabs", "Blender and 3ds Max exporters", "tabs before and behind keywords, CRLF, trailing blanks",
     {**textured("newmtl\tm  \r\n\tKd\t1\t1\t1 \r\n\tmap_Kd\ttex.png \t\r\n", "usemtl\tm \n"), **TEXTURE}, ok(rgb=RED))
case("mtl_paths", "mrdoob/three.js, OBJ of Windows programs", "./ and .\\ before the names, folders, quotes",
     {"a.obj": obj("f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n", "mtllib ./lib\\a.mtl\n", "usemtl m\n"),
      "lib/a.mtl": b"newmtl m\nmap_Kd .\\maps/tex.png\n",
      "lib/maps/tex.png": plain_png(255, 0, 0),
      "b.obj": obj("f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n", "mtllib b.mtl\n", "usemtl m\n"),
      "b.mtl": b'newmtl m\nmap_Kd "lib\\maps\\tex.png"\n'},
     ok(rgb=RED))
case("mtl_comments", "Wavefront, MTL", "comments behind colors and between lines",
     {**textured("# Kd 0 0 1\nnewmtl m\n#newmtl n\nKd 1 0 0 # red\n", "usemtl m\n")}, ok(rgb=RED))
case("mtl_names_with_hashes", "Autodesk 3ds Max: `Material #25`", "a hash in the name of a material begins no comment",
     {**textured("newmtl Material #25\nKd 1 0 0\nnewmtl Material #26\nKd 0 0 1\n", "usemtl Material #25\n")},
      ok(rgb=RED))
case("mtl_inline_comments", "kovacsv/Online3DViewer, tests of OBJ and STL", "comments behind usemtl, mtllib, map_Kd and vertices",
     {"a.obj": (OBJ_VERTICES + OBJ_COORDINATES).replace("\n", " # a comment\n").encode() + b"mtllib a.mtl # inline\n"
               b"usemtl red # inline\nf 1/1 2/2 3/3 # inline\nusemtl Material #25 # inline\nf 1/1 3/3 4/4\n",
      "a.mtl": b"newmtl red # not a part of it\nnewmtl red\nmap_Kd tex #1.png # inline\n"
               b"newmtl Material #25\nKd 1 0 0 # inline\n", "tex #1.png": plain_png(255, 0, 0),
      "b.stl": b"# first\n" + ascii_stl("x # a name").replace(b"\n", b" # inline\n # another\n"),
      "c.ply": square_ply().replace(b"end_header\n", b"end_header\ncomment one\n\n").replace(b"1 1 0\n", b"1 1 0\ncomment 2 of 3\n")},
     {"a.obj": ok(rgb=RED), "b.stl": ok(), "c.ply": ok()})
case("mtl_options_behind", "mrdoob/three.js 7943; tinyobjloader/tinyobjloader 184", "options behind the name, -colorspace",
     {"a.obj": textured("", library="a.mtl")["model.obj"], "a.mtl": b"newmtl m\nmap_Kd -colorspace sRGB -o 0.1 tex.png\n",
      "b.obj": textured("", library="b.mtl")["model.obj"], "b.mtl": b"newmtl m\nmap_Kd tex.png -s 1 1 1 -bm 0.5\n",
      "c.obj": textured("", library="c.mtl")["model.obj"], "c.mtl": b"newmtl m\nmap_Kd my -s tex.png\n",
      "tex.png": plain_png(255, 0, 0), "my -s tex.png": plain_png(255, 0, 0)}, ok(rgb=RED))
case("mtl_escaped_blanks", "tinyobjloader/tinyobjloader 46", "names of libraries and images with `\\ ` for a blank",
     {"a.obj": obj("f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n", "mtllib none.mtl not\\ there.mtl  my\\ own.mtl\n", "usemtl m\n"),
      "my own.mtl": b"newmtl m\nmap_Kd my\\ tex.png\n", "my tex.png": plain_png(255, 0, 0)}, ok(rgb=RED))
case("obj_painted_vertices", "pmp-library/pmp-library PR 200; ZBrush, OBJ",
     "colors of vertices in comments #MRGB, 8 digits each",
     {"one.obj": OBJ_VERTICES.encode() + b"#MRGB ffff0000ffff0000ffff0000ffff0000\nf 1 2 3\nf 1 3 4\n",
      "two.obj": OBJ_VERTICES.encode() + b"#MRGB FFFF0000FFFF0000\n#MRGB FFFF0000FFFF0000\nf 1 2 3\nf 1 3 4\n"},
      ok(rgb=RED))
case("mtl_opacity", "tinyobjloader/tinyobjloader 43: d and Tr", "d, Tr and illum change no color",
     {**textured("newmtl m\nKd 1 0 0\nd 0.0\nTr 1.0\nillum 9\nNi 1.5\nmap_d tex.png\n"), **TEXTURE}, ok(rgb=RED))
case("mtl_spectral", "Wavefront, MTL: Kd xyz and Kd spectral", "colors by CIEXYZ are no RGB",
     {**textured("newmtl m\nKd xyz 0.4124 0.2126 0.0193\n")}, ok(rgb=FILL))
case("mtl_gray_of_one_number", "Wavefront, MTL: g and b are r where they are not given", "Kd of one number",
     {**textured("newmtl m\nKd 0.2\n")}, ok(rgb=(51, 51, 51)))
case("mtl_several_libraries", "Wavefront, OBJ: mtllib takes several names",
     "two libraries on a line, one of them missing",
     {"a.obj": obj("usemtl m\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n", "mtllib missing.mtl one.mtl two.mtl\n"),
      "one.mtl": b"newmtl n\nKd 0 0 1\n",
      "two.mtl": b"newmtl m\nKd 1 0 0\n"}, ok(rgb=RED))
case("mtl_between_faces", "obj of Rhino and of SketchUp",
     "mtllib behind the faces, usemtl in groups, materials of names with blanks",
     {"a.obj": obj("g left\nusemtl my red\nf 1 2 3\ng right\ns 1\nf 1 3 4\nmtllib a.mtl\n"),
      "a.mtl": b"newmtl my red\nKd 1 0 0\n"}, ok(rgb=RED))
case("mtl_name_of_image_ends_line", "graspnet/graspnetAPI 34",
     "an image that is missing: no color, and not that of the factor",
     {**textured("newmtl m\nKd 1 0 0\nmap_Kd close.jpg\n")}, ok(rgb=FILL))
case("obj_texture_v", "facebookresearch/pytorch3d, textures are read from below", "v points upwards",
     {**textured("newmtl m\nmap_Kd -clamp on t.png\n", faces="f 1/1 2/1 3/1\nf 1/1 3/1 4/1\n"), "t.png": png(1, 2,
      bytes(BLUE + RED))},
     ok(rgb=RED))

# ---- STL -------------------------------------------------------------------------------------------------------------

case("stl_names", "cnr-isti-vclab/meshlab 734; Wikipedia, STL", "names of solids that hold keywords, or are very long",
     {"facet.stl": ascii_stl("facet of a vertex loop"), "end.stl": ascii_stl("endsolid"),
      "vertex.stl": ascii_stl("vertex 1 2 3"),
      "long.stl": ascii_stl("2STL_V_1_0" + "/" * 500 + "BYE"), "none.stl": ascii_stl(),
      "latin.stl": ascii_stl("x").replace(b"solid x", b"solid Geh\xe4use"),
      "utf8.stl": ascii_stl("\u6728\u76ee \u2116 5")}, ok())
case("stl_upper_case", "assimp/assimp, STL keywords in any case", "all keywords in capitals",
     {"a.stl": ascii_stl("PART").upper()}, ok())
case("stl_leading_blanks", "wolph/numpy-stl 156; mrdoob/three.js PR 14522", "a blank or a line before `solid`",
     {"blank.stl": b" " + ascii_stl("x"), "line.stl": b"\r\n\n" + ascii_stl("x"),
      "mark.stl": b"\xef\xbb\xbf" + ascii_stl("x")}, ok())
case("stl_binary_solid", "libigl/libigl 26; sreiter/stl_reader 3", "binary files that begin with solid",
     {"a.stl": binary_stl(b"solid part"), "b.stl": binary_stl(b"solid part\n facet normal"),
      "c.stl": binary_stl(b"solid " + b" " * 74),
      "d.stl": binary_stl(b"solid x", rest=b"\0\0")}, ok())
case("stl_wrong_count", "mikedh/trimesh 236; writers that stream", "counts of 0, of -1, and too large",
     {"zero.stl": binary_stl(count=0), "unknown.stl": binary_stl(count=0xFFFFFFFF), "more.stl": binary_stl(count=5)},
      ok())
case("stl_fewer", "3D Systems, StereoLithography Interface Specification", "a count smaller than what is there",
     {"a.stl": binary_stl(count=1)}, ok(0.5))
case("stl_attribute_bytes", "Wikipedia, STL: attribute byte count",
     "attribute words that are not 0 without a valid color",
     {"a.stl": binary_stl(attribute=2)}, ok(rgb=FILL))
case("stl_normals", "nschloe/meshio 745", "normals that are 0, NaN, turned or missing",
     {"zero.stl": binary_stl(normal=(0, 0, 0)), "nan.stl": binary_stl(normal=(float("nan"),) * 3),
      "turned.stl": binary_stl(normal=(0, 0, -5)),
      "text_nan.stl": ascii_stl(facet="facet normal nan -nan(ind) 1.#QNAN"), "text_none.stl": ascii_stl(facet="facet"),
      "exponent.stl": ascii_stl(facet="facet normal 0.000000e+00 -0.0E-00 1.E+00")}, ok())
case("stl_delimiters", "nschloe/meshio PR 642", "tabs, several blanks, CR alone, CRLF, all on one line",
     {"tabs.stl": ascii_stl("x", vertex="\tvertex\t{}\t {}\t{}  "), "cr.stl": ascii_stl("x", eol="\r"),
      "crlf.stl": ascii_stl("x", eol="\r\n"),
      "line.stl": ascii_stl("x", eol=" ")}, ok())
case("stl_several_solids", "OpenFOAM: one file of several patches", "several solids, one of them empty",
     {"a.stl": b"solid none\nendsolid none\n" + ascii_stl("a") + ascii_stl("b").replace(b"0 0 0",
      b"0 0 0").replace(b"vertex 1", b"vertex 2")},
     ok(3, (0, 0, 0, 2, 1, 0)))
case("stl_ends", "assimp/assimp 102 and files of OpenSCAD",
     "endsolid with another name, without one, missing, and text behind it",
     {"other.stl": ascii_stl("x", end="endsolid y z"), "none.stl": ascii_stl("x", end="ENDSOLID"),
      "missing.stl": ascii_stl("x", end=""),
      "behind.stl": ascii_stl("x", end="endsolid x\n\n# exported by hand\n\0\0\0")}, ok())
case("stl_open_facets", "strands-labs/robots 2661",
     "endfacet or endloop is missing behind the last facet, or behind all",
     {"last.stl": ascii_stl("x")[::-1].replace(b"tecafdne", b"", 1)[::-1],
      "all.stl": ascii_stl("x").replace(b"endfacet", b"")
      .replace(b"endloop", b"")}, ok())
case("stl_nothing", "mikedh/trimesh, empty files", "a solid without facets, an empty file",
     {"solid.stl": b"solid x\nendsolid x\n", "none.stl": b""}, fails("empty"))

# ---- glTF ------------------------------------------------------------------------------------------------------------

mirrored = Gltf().square()
mirrored.json["nodes"] = [{"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1]}]
case("gltf_matrices", "KhronosGroup/glTF-Sample-Models, NegativeScaleTest",
     "a matrix that mirrors keeps the outside outside",
     {"a.gltf": mirrored.gltf()}, ok(normal=(0, 0, 1)))

sparse = Gltf()
sparse.primitive["attributes"]["POSITION"] = 0
sparse.json["accessors"].append(
    {"componentType": 5126, "type": "VEC3", "count": 4, "sparse": {
        "count": 3, "indices": {"bufferView": sparse.view(bytes([1, 2, 3])), "componentType": 5121},
        "values": {"bufferView": sparse.view(b"".join(struct.pack("<3f", *v) for v in SQUARE[1:]))}}})
sparse.primitive["indices"] = sparse.accessor("B", "SCALAR", [0, 1, 2, 0, 2, 3])
case("gltf_sparse_without_view", "KhronosGroup/glTF 2.0, 3.6.2.3: zeros without a buffer view",
     "a sparse accessor over zeros",
     {"a.gltf": sparse.gltf(), "a.glb": sparse.glb()}, ok())
case("gltf_indices", "KhronosGroup/glTF 2.0, 3.7.2: types of indices", "indices of 8, 16 and 32 bits, and none",
     {"b.glb": Gltf().square("B").glb(), "h.glb": Gltf().square("H").glb(), "i.glb": Gltf().square("I").glb(),
      "none.glb": Gltf().square("", vertices=[SQUARE[c] for t in HALVES for c in t]).glb()}, ok())
case("gltf_stride", "KhronosGroup/glTF 2.0, 3.6.2.4: byteStride", "interleaved positions",
     {"a.glb": Gltf().square(pad=8).glb()}, ok())

strip = Gltf().square("")
strip.primitive.update(mode=5, indices=strip.accessor("H", "SCALAR", [0, 1, 2, 65535, 0, 2, 3]))
case("gltf_restart", "KhronosGroup/glTF PR 1476 and 2569: primitive restart", "the largest index ends a strip",
     {"a.glb": strip.glb()}, ok())
unlit = Gltf().square().material(pbrMetallicRoughness={"baseColorFactor": [1, 0, 0, 0]},
     extensions={"KHR_materials_unlit": {}},
                                 alphaMode="MASK", doubleSided=True)
unlit.set(extensionsUsed=["KHR_materials_unlit"], extensionsRequired=["KHR_materials_unlit"])
case("gltf_unlit", "KhronosGroup/glTF, KHR_materials_unlit",
     "an unlit, masked, double-sided material has its base color",
     {"a.glb": unlit.glb()}, ok(rgb=RED))
variants = Gltf().square().material(pbrMetallicRoughness={"baseColorFactor": [1, 0, 0, 1]})
variants.json["materials"].append({"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 1, 1]}})
variants.primitive["extensions"] = {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}}
variants.set(extensionsUsed=["KHR_materials_variants"],
     extensions={"KHR_materials_variants": {"variants": [{"name": "blue"}]}})
case("gltf_variants", "KhronosGroup/glTF, KHR_materials_variants",
     "the material of the primitive, not that of a variant",
     {"a.glb": variants.glb()}, ok(rgb=RED))


def vertex_colors(code, values, **more):
    model = Gltf().square()
    model.primitive["attributes"]["COLOR_0"] = model.accessor(code, f"VEC{len(values)}", list(values) * 4, **more)
    return model.glb()


case("gltf_vertex_colors", "mrdoob/three.js 12481; playcanvas/engine 2053",
     "normalized bytes and shorts, with and without alpha",
     {"u8.glb": vertex_colors("B", (255, 0, 0, 0), normalized=True), "u16.glb": vertex_colors("H", (65535, 0, 0),
      normalized=True),
      "float.glb": vertex_colors("f", (1, 0, 0, 1))}, ok(rgb=RED))
case("gltf_color_beyond_one", "KhronosGroup/glTF-Sample-Models 337: COLOR_0 must be clamped to [0, 1]",
     "float colors above 1",
     {"a.glb": vertex_colors("f", (255, 0, 0, 255))}, ok(rgb=RED))

second = Gltf().square().coordinates("TEXCOORD_0", [0.25, 0.5] * 4).coordinates("TEXCOORD_1", [0.75, 0.5] * 4)
case("gltf_second_coordinates", "KhronosGroup/glTF-Sample-Models, MultiUVTest", "texCoord 1",
     {"a.glb": second.texture(two_png(BLUE, RED), texCoord=1).glb()}, ok(rgb=RED))
moved = Gltf().square().coordinates("TEXCOORD_0", [0.25, 0.5] * 4)
moved.set(extensionsUsed=["KHR_texture_transform"])
case("gltf_texture_transform", "KhronosGroup/glTF, KHR_texture_transform", "an offset into the other half",
     {"a.glb": moved.texture(two_png(BLUE, RED), extensions={"KHR_texture_transform": {"offset": [0.5, 0]}}).glb()},
      ok(rgb=RED))
case("gltf_samplers", "KhronosGroup/glTF 2.0, 3.8.4: wrapping", "clamped, mirrored and repeated coordinates",
     {f"{name}.glb": Gltf().square().coordinates("TEXCOORD_0", [u, 0.5] * 4).texture(two_png(BLUE, RED),
      {"wrapS": mode}).glb()
      for name, mode, u in (("clamp", 33071, 3.1), ("mirror", 33648, 1.25), ("repeat", 10497, -0.25), ("default",
      10497, 2.75))},
     ok(rgb=RED))



def typed_coordinates(code, u, v, **more):
    model = Gltf().square()
    model.primitive["attributes"]["TEXCOORD_0"] = model.accessor(code, "VEC2", [u, v] * 4, **more)
    return model


shifted = typed_coordinates("H", 3072, 2048)
shifted.set(extensionsUsed=["KHR_mesh_quantization", "KHR_texture_transform"],
            extensionsRequired=["KHR_mesh_quantization"])
case("gltf_coordinate_types", "KhronosGroup/glTF 2.0, 3.7.2.1: texture coordinates of bytes and shorts; gltfpack",
     "normalized texture coordinates, and whole numbers that a transform scales",
     {"u8.glb": typed_coordinates("B", 192, 128, normalized=True).texture(two_png(BLUE, RED)).glb(),
      "u16.glb": typed_coordinates("H", 49152, 32768, normalized=True).texture(two_png(BLUE, RED)).glb(),
      "scaled.glb": shifted.texture(two_png(BLUE, RED), extensions={"KHR_texture_transform": {
          "scale": [1 / 4096, 1 / 4096]}}).glb()}, ok(rgb=RED))
scenes = Gltf().square().set(nodes=[{"mesh": 0}, {"mesh": 0, "translation": [0, 0, 7]}],
                             scenes=[{"nodes": [1]}, {"nodes": [0]}])
case("gltf_scenes", "KhronosGroup/glTF 2.0, 3.5.1: scene", "the chosen scene of two, or the first",
     {"second.glb": scenes.set(scene=1).glb(), "first.glb": scenes.without("scene").glb()},
     {"second.glb": ok(), "first.glb": ok(1, (0, 0, 7, 1, 1, 7))})
painted = Gltf().square().coordinates().texture(plain_png(255, 255, 255))
painted.primitive["attributes"]["COLOR_0"] = painted.accessor("f", "VEC3", [1, 0, 0] * 4)
case("gltf_color_times_texture", "KhronosGroup/glTF 2.0, 3.9.2: COLOR_0 multiplies the base color",
     "red vertices on a white image",
     {"a.glb": painted.glb()}, ok(rgb=RED))
skin = Gltf().square()
skin.primitive["attributes"].update(JOINTS_0=skin.accessor("B", "VEC4", [0, 0, 0, 0] * 4), WEIGHTS_0=skin.accessor("f",
     "VEC4", [1, 0, 0, 0] * 4))
skin.set(nodes=[{"mesh": 0, "skin": 0, "translation": [9, 9, 9]}, {"translation": [0, 0, 2]}], skins=[{"joints": [1]}],
         scenes=[{"nodes": [0, 1]}])
case("gltf_skin_without_matrices", "KhronosGroup/glTF 2.0, 3.7.3.3: identity without inverseBindMatrices",
     "a skin moves by its joints alone; the node's own place is ignored", {"a.glb": skin.glb()}, ok(1, (0, 0, 2, 1, 1,
     2)))
camera = Gltf().square()
camera.set(nodes=[{"camera": 0}], cameras=[{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}])
case("gltf_nothing_to_draw", "KhronosGroup/glTF 2.0, 3.5.1: nodes without meshes", "a camera alone",
     {"camera.glb": camera.glb()}, fails("empty", "no triangles"))
case("gltf_library_of_meshes", "atteneder/glTFast 422", "meshes without any node or scene",
     {"a.glb": Gltf().square().without("scene", "scenes", "nodes").glb()}, ok())
case("gltf_old_versions", "glTF 1.0 and its binary form KHR_binary_glTF", "files of version 1",
     {"a.glb": Gltf().square().glb(version=1), "b.gltf": Gltf().square().set(asset={"version": "1.0"}).gltf()},
      fails("unsupported_format", "1"))

BIN = Gltf().square().buffer
case("gltf_uris", "KhronosGroup/glTF 1449 and 2245; KhronosGroup/glTF-Blender-IO 1836",
     "buffers whose names have blanks, percent signs and letters beyond ASCII, encoded and not",
     {"blank.gltf": Gltf().square().gltf("big ball.bin"), "encoded.gltf": Gltf().square().gltf("big%20ball.bin"),
      "percent.gltf": Gltf().square().gltf("example 10%.bin"),
      "percent_encoded.gltf": Gltf().square().gltf("example%2010%25.bin"),
      "dot.gltf": Gltf().square().gltf("./big%20ball.bin"), "letters.gltf": Gltf().square().gltf("\u6728.bin"),
      "letters_encoded.gltf": Gltf().square().gltf("%E6%9C%A8.bin"), "plus.gltf": Gltf().square().gltf("a+b.bin"),
      "big ball.bin": BIN, "example 10%.bin": BIN, "\u6728.bin": BIN, "a+b.bin": BIN}, ok())
case("gltf_uri_query", "AnalyticalGraphicsInc/gltf-vscode 69",
     "a query behind the name of a buffer is part of the name: a sentence names it",
     {"a.gltf": Gltf().square().gltf("data.bin?v=2"), "data.bin": BIN}, fails("unreadable", "data.bin?v=2"))
case("gltf_data_uris", "KhronosGroup/glTF-Blender-IO 635; jessey-git/fx-gltf 68; RFC 2397",
     "data URIs of any media type, and without base64",
     {"charset.gltf": Gltf().square().gltf(head="data:application/octet-stream;charset=utf-8;base64,"),
      "buffer.gltf": Gltf().square().gltf(head="data:application/gltf-buffer;base64,"),
      "bare.gltf": Gltf().square().gltf(head="data:;base64,"),
      "capitals.gltf": Gltf().square().gltf(head="DATA:Application/Octet-Stream;BASE64,"),
      "percent.gltf": Gltf().square().gltf("data:," + "".join(f"%{b:02x}" for b in BIN))}, ok())
case("gltf_glb_containers", "syoyo/tinygltf 79; KhronosGroup/glTF 2.0, 4.4",
     "data URIs and files named by a .glb, unknown chunks, padding, bytes behind the end",
     {"uri.glb": Gltf().square().glb(uri="data.bin"), "data.bin": BIN, "null.glb": Gltf().square().glb(pad=b"\0"),
      "rest.glb": Gltf().square().glb(rest=b"trailing"), "chunk.glb": Gltf().square().glb(extra=struct.pack("<II", 4,
      0x58585858) + b"abcd")}, ok())
case("gltf_byte_order_mark",
     "KhronosGroup/glTF 2.0, 2.7: JSON without a byte-order mark; implementations may ignore one",
     "a byte-order mark before the JSON",
     {"a.gltf": b"\xef\xbb\xbf" + Gltf().square().gltf()}, ok())
unused = Gltf().square().set(buffers=[{}, {"byteLength": 8, "uri": "gone.bin"}])
case("gltf_unused_buffers", "KhronosGroup/glTF-Validator, UNUSED_OBJECT", "a missing buffer that no geometry needs",
     {"a.gltf": unused.gltf()}, ok())
quantized = Gltf().square(code="h", pad=2)
quantized.set(extensionsUsed=["KHR_mesh_quantization"], extensionsRequired=["KHR_mesh_quantization"],
              nodes=[{"mesh": 0, "scale": [2, 2, 2], "translation": [0.5, 0, 0]}])
case("gltf_quantized", "KhronosGroup/glTF, KHR_mesh_quantization",
     "whole-number positions, scaled and moved by their node",
     {"a.glb": quantized.glb()}, ok(4, (0.5, 0, 0, 2.5, 2, 0)))
hidden = Gltf().square().set(nodes=[{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0],
     "extensions": {"KHR_node_visibility": {"visible": False}}}],
                             scenes=[{"nodes": [0, 1]}], extensionsUsed=["KHR_node_visibility"])
case("gltf_hidden_nodes", "KhronosGroup/glTF PR 2410; KhronosGroup/glTF-Blender-IO 2597",
     "nodes that are not visible are not drawn", {"a.glb": hidden.glb()}, ok())
levels = Gltf().square().set(nodes=[{"mesh": 0, "extensions": {"MSFT_lod": {"ids": [1]}}}, {"mesh": 0,
     "translation": [5, 0, 0]}],
                             extensionsUsed=["MSFT_lod"])
case("gltf_levels", "KhronosGroup/glTF, MSFT_lod", "coarser levels are not drawn beside the finest",
     {"a.glb": levels.glb()}, ok())


def skinned(code, weights, **more):
    model = Gltf().square()
    model.primitive["attributes"].update(JOINTS_0=model.accessor("B", "VEC4", [0, 0, 0, 0] * 4),
                                         WEIGHTS_0=model.accessor(code, "VEC4", weights * 4, **more))
    return model.set(nodes=[{"mesh": 0, "skin": 0}, {"name": "joint"}], skins=[{"joints": [1]}], scenes=[{"nodes": [0,
    1]}]).glb()


case("gltf_skin_weights", "mrdoob/three.js 15319; KhronosGroup/glTF 1213; KhronosGroup/glTF-Sample-Models 215",
     "weights whose sum is not 1 shrink nothing",
     {"half.glb": skinned("f", [0.5, 0, 0, 0]), "bytes.glb": skinned("B", [250, 0, 0, 0], normalized=True),
      "exact.glb": skinned("B", [255, 0, 0, 0], normalized=True)}, ok())
plain_part = Gltf().square().material(pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 1]})
del plain_part.primitive["material"]
case("gltf_default_material", "KhronosGroup/glTF 1034 and 1182",
     "parts without a material, in a file that has some, have no color",
     {"a.glb": plain_part.glb()}, ok(rgb=FILL))
positionless = Gltf().square()
positionless.json["meshes"][0]["primitives"].append({"attributes": {}})
case("gltf_no_positions", "KhronosGroup/glTF 2.0, 3.7.2.1: a primitive without positions is skipped",
     "a primitive that positions are missing of",
     {"a.glb": positionless.glb()}, ok())


def image_file(uri):
    model = Gltf().square().coordinates().texture(b"")
    return model.set(images=[{"uri": uri}]).gltf()


case("gltf_image_names", "KhronosGroup/UnityGLTF 241; zeux/meshoptimizer 138",
     "names of images with blanks, encoded and not",
     {"a.gltf": image_file("WOOD%20BIRCH%20v2.png"), "b.gltf": image_file("WOOD BIRCH v2.png"),
      "c.gltf": image_file("maps/10%.png"),
      "WOOD BIRCH v2.png": plain_png(255, 0, 0), "maps/10%.png": plain_png(255, 0, 0)}, ok(rgb=RED))
case("gltf_specular_glossiness", "KhronosGroup/glTF, KHR_materials_pbrSpecularGlossiness", "diffuseFactor alone",
     {"a.glb": Gltf().square().material(extensions={"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 0, 0,
      1]}}).glb()}, ok(rgb=RED))
case("gltf_linear_factor", "KhronosGroup/glTF 2.0, 3.9.2: factors are linear, textures sRGB",
     "a factor of 0.5 is stored as 188, a pixel of 128 as 128",
     {"factor.glb": Gltf().square().material(pbrMetallicRoughness={"baseColorFactor": [0.5, 0.5, 0.5, 1]}).glb(),
      "texture.glb": Gltf().square().coordinates().texture(plain_png(128, 128, 128)).glb()},
     {"factor.glb": ok(rgb=(188, 188, 188)), "texture.glb": ok(rgb=(128, 128, 128))})
case("png_kinds", "KhronosGroup/glTF-Asset-Generator, textures", "gray, gray with alpha, palette, 16 bits",
     {"gray.glb": Gltf().square().coordinates().texture(png(1, 1, b"\x80", 0)).glb(),
      "alpha.glb": Gltf().square().coordinates().texture(png(1, 1, b"\x80\x00", 4)).glb(),
      "palette.glb": Gltf().square().coordinates().texture(png(1, 1, b"\x80", 3, 1, bytes((0, 0, 0, 128, 128,
      128)))).glb(),
      "deep.glb": Gltf().square().coordinates().texture(png(1, 1, b"\x80\x80" * 3, 2, 16)).glb()}, ok(rgb=(128, 128,
      128)))

# ---- Data sets -------------------------------------------------------------------------------------------------------

plain = obj("f 1 2 3\nf 1 3 4\n")
case("layout_shapenet_v1", "DLR-RM/BlenderProc 1023; ShapeNetCore.v1: SYNSET/ID/model.obj, images/",
     "classes from the folders, textures beside the model",
     {f"02691156/{i}/{f}": data for i in ("a1", "b2") for f, data in (
         ("model.obj", textured("")["model.obj"]), ("model.mtl", b"newmtl m\nmap_Kd ./images/texture0.png\n"),
         ("images/texture0.png", plain_png(255, 0, 0)))},
     {f"02691156/{i}/model.obj": ok(rgb=RED, label="02691156") for i in ("a1", "b2")}, ["--layout", "auto"])
case("layout_shapenet_v2", "ShapeNetCore.v2: SYNSET/ID/models/model_normalized.obj", "classes from the folders",
     {f"02691156/{i}/models/model_normalized.{f}": data for i in ("a1", "b2") for f, data in (("obj", plain), ("json",
      b"{}"), ("solid.binvox", b"#"))},
     {f"02691156/{i}/models/model_normalized.obj": ok(label="02691156") for i in ("a1", "b2")}, ["--layout", "auto"])
case("layout_modelnet", "ModelNet40: CLASS/train/CLASS_0001.off", "classes and splits, counts glued to the keyword",
     {f"{c}/{s}/{c}_000{n}.off": off("OFF4 2 0", "") for c in ("night_stand", "tv_stand") for n, s in ((1, "train"),
      (2, "test"))},
     {f"{c}/{s}/{c}_000{n}.off": ok(label=c, split=s) for c in ("night_stand", "tv_stand") for n, s in ((1, "train"),
      (2, "test"))}, ["--layout", "auto"])
case("layout_modelnet_resampled", "yanx27/Pointnet_Pointnet2_pytorch 121: CLASS/CLASS_0001.txt of six columns",
     "point sets are no meshes: a sentence, no store",
     {"airplane/airplane_0001.txt": b"0,0,0,0,0,1\n", "airplane/airplane_0002.txt": b"0,0,0,0,0,1\n",
      "filelist.txt": b"airplane/airplane_0001.txt\n"},
     {}, ["--layout", "auto"], 2, "no mesh file")
case("layout_3d_future", "3D-FUTURE: ID/raw_model.obj, normalized_model.obj, model.mtl, texture.png",
     "two models that share a library",
     {f"0a1b/{f}": data for f, data in (("raw_model.obj", textured("")["model.obj"]), ("normalized_model.obj",
      textured("")["model.obj"]),
                                        ("model.mtl", b"newmtl m\nKd 0.8 0.8 0.8\nmap_Kd ./texture.png\n"),
                                        ("texture.png", png(1, 1, bytes(RED))),
                                        ("image.jpg", b"not looked at"))}, ok(rgb=(204, 0, 0)))
case("layout_scanned_objects", "Google Scanned Objects on Gazebo Fuel: meshes/model.obj, materials/textures/*.png",
     "the library names an image that lies in another folder: it is missing; beside the library it is found",
     {f"{name}/{path}": data for name, image in (("Fuel", "materials/textures"), ("Copied", "meshes"))
      for path, data in (
         ("meshes/model.obj", textured("")["model.obj"]),
         ("meshes/model.mtl", b"newmtl m\nKd 1 1 1\nmap_Kd texture.png\n"),
         (f"{image}/texture.png", plain_png(255, 0, 0)), ("model.sdf", b"<sdf/>"))},
     {"Fuel/meshes/model.obj": ok(rgb=FILL), "Copied/meshes/model.obj": ok(rgb=RED)})
case("layout_abc", "ABC: obj_v00/00000050/00000050_HASH_trimesh_000.obj",
     "many files of one folder each, others are counted",
     {f"obj_v00/000000{n}/000000{n}_80d9_trimesh_000.obj": plain for n in (50,
      51)} | {"feat_v00/00000050/x.yml": b"a: 1\n"}, ok())
case("layout_thingi10k", "Thingi10K: raw_meshes/ID.stl, .obj, .ply, .off", "formats side by side, numbers as names",
     {"raw_meshes/100026.stl": binary_stl(), "raw_meshes/100027.obj": plain, "raw_meshes/100028.ply": square_ply(),
      "raw_meshes/100029.OFF": off()}, ok())
case("layout_scannet", "ScanNet/ScanNet 90: scene0000_00/scene0000_00_vh_clean_2.labels.ply",
     "colors with alpha and a label of 16 bits behind them",
     {"scans/scene0000_00/scene0000_00_vh_clean_2.labels.ply": ply(
         ["element vertex 4", *XYZ, *(f"property uchar {c}" for c in ("red", "green", "blue", "alpha")),
         "property ushort label", "element face 2",
          "property list uchar int vertex_indices"],
         b"".join(struct.pack("<3f4BH", *v, 255, 0, 0, 255,
         40) for v in SQUARE) + b"".join(packed("B3i")(t) for t in HALVES), "binary_little_endian")},
     ok(rgb=RED))
case("layout_other_archives", "ABC and Objaverse mirrors: .7z and .rar",
     "archives that are not read end with a sentence",
     {"set.7z": b"7z\xbc\xaf\x27\x1c" + b"\0" * 26}, {}, ["--layout", "auto"], 2, "no mesh file")

red_model = {**textured("newmtl m\nmap_Kd maps\\tex.png\n"), "maps/tex.png": plain_png(255, 0, 0)}
case("archive_backslashes", "icsharpcode/SharpZipLib 617; dotnet/runtime 98247",
     "zip archives of PowerShell 5: backslashes in names",
     {"set.zip": zipped({"set\\" + path.replace("/", "\\"): data for path, data in red_model.items()}, host=0)},
     {"set/model.obj": ok(rgb=RED)})
case("archive_of_macos", "Archive Utility of macOS: __MACOSX/._NAME",
     "shadow files of resource forks are hidden, not models",
     {"set.zip": zipped({**{f"set/{path}": data for path, data in red_model.items()},
                         "__MACOSX/set/._model.obj": b"\0\5\26\7", "set/.DS_Store": b"\0"})},
     {"set/model.obj": ok(rgb=RED)})
case("packed_meshes", "gzip, RFC 1952: several members in a file", "MESH.gz, also of two members",
     {"a.ply.gz": gzip.compress(square_ply(), mtime=0),
      "b.stl.gz": gzip.compress(binary_stl()[:50], mtime=0) + gzip.compress(binary_stl()[50:], mtime=0)},
     {"a.ply": ok(), "b.stl": ok()})


# ---- The check -------------------------------------------------------------------------------------------------------

def write(folder, files):
    for path, data in files.items():
        full = os.path.join(folder, path)
        os.makedirs(os.path.dirname(full), exist_ok=True)
        with open(full, "wb") as file:
            file.write(data)


def run(program, folder, store, options):
    command = [program, "run", folder, "-o", store, "-n", str(SAMPLES), "--colors", "-j", "2", "--progress", "none"]
    return subprocess.run([*command, *options], capture_output=True, text=True, encoding="utf-8", errors="replace")


def names_of(values):
    return [n.decode() if isinstance(n, bytes) else n for n in values]


def stored_rows(store):
    """By id: what the store says of one model."""
    with h5py.File(store, "r") as file:
        items = file["items"]
        words = {name: {v: k for k, v in h5py.check_enum_dtype(items[name].dtype).items()}
                 for name in ("status", "split")}
        repairs, classes = names_of(items["repairs"].attrs["names"]), names_of(file["label"].attrs["names"])
        ids, reasons = names_of(items["id"][:]), names_of(items["reason"][:])
        rows = {}
        for r, i in enumerate(ids):
            label = file["label"][r, 0]
            rows[i] = dict(status=words["status"][items["status"][r]], split=words["split"][items["split"][r]],
                           reason=reasons[r], label=classes[label] if label >= 0 else "",
                           area=items["area"][r], box=items["bbox"][r],
                           repairs=dict(zip(repairs, items["repairs"][r].tolist())),
                           normals=file["normals"][r], rgb=file["rgb"][r].astype(int))
        return rows


def off_by(values, expected):
    return numpy.abs(values - numpy.asarray(expected)).max()


def faults_of(row, expected):
    """Sentences: what differs from what is right."""
    if row is None:
        return ["there is no row"]
    if row["status"] != expected["status"]:
        return [f"{row['status']} ({row['reason']})" if row["reason"] else f"{row['status']}, area {row['area']:.6g}"]
    found = []
    if expected.get("reason", "") not in row["reason"]:
        found.append(f"the reason is: {row['reason']}")
    if expected["status"] != "ok":
        return found
    if abs(row["area"] - expected["area"]) > 1e-6 * expected["area"]:
        found.append(f"area {row['area']:.6g}")
    if off_by(row["box"], expected["box"]) > 1e-6:
        found.append(f"box {' '.join(f'{v:g}' for v in row['box'])}")
    if "rgb" in expected and off_by(row["rgb"], expected["rgb"]) > 1:
        colors = sorted({tuple(c) for c in row["rgb"].tolist()})
        found.append("colors " + " ".join(map(str, colors[:3])) + (" ..." if len(colors) > 3 else ""))
    if "normal" in expected and off_by(row["normals"], expected["normal"]) > 1e-6:
        found.append(f"normal {row['normals'][0]}")
    repairs = expected.get("repairs", {})
    found += [f"{row['repairs'][name]} {name}" for name, count in repairs.items() if row["repairs"][name] != count]
    found += [f"{key} `{row[key]}`" for key in ("label", "split") if key in expected and row[key] != expected[key]]
    return found


def print_table():
    print("| case | where | subject |\n|---|---|---|")
    for c in CASES:
        print(f"| {c.name} | {c.where} | {c.subject} |")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", nargs="?")
    parser.add_argument("names", nargs="*")
    parser.add_argument("--keep")
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_intermixed_args()
    if arguments.list:
        return print_table()
    chosen = [c for c in CASES if not arguments.names or c.name in arguments.names]
    wrong, checked = 0, 0
    with tempfile.TemporaryDirectory() as scratch:
        root = os.path.join(arguments.keep or scratch, "cases")
        common = [c for c in chosen if not c.options]
        for c in chosen:
            write(os.path.join(root if not c.options else root + "_alone", c.name), c.files)
        common_rows = {}
        if common:
            store = os.path.join(scratch, "common.h5")
            result = run(arguments.program, root, store, ["--layout", "flat"])
            common_rows = stored_rows(store) if os.path.exists(store) else {}
            if not common_rows or result.returncode not in (0, 3):
                print(result.stderr)
                return 1
        for c in chosen:
            faults = []
            found = {i[len(c.name) + 1:]: row for i, row in common_rows.items() if i.startswith(c.name + "/")}
            if c.options:
                store = os.path.join(scratch, c.name + ".h5")
                result = run(arguments.program, os.path.join(root + "_alone", c.name), store, c.options)
                found = stored_rows(store) if os.path.exists(store) else {}
                if c.code is not None and result.returncode != c.code:
                    faults.append(f"exit code {result.returncode}: {result.stderr.strip()}")
                if c.says not in result.stderr + result.stdout:
                    faults.append(f"says: {result.stderr.strip()}")
            faults += [f"{path}: {fault}" for path, expected in c.rows.items()
                       for fault in faults_of(found.get(path), expected)]
            faults += [f"{path}: not expected" for path in found if path not in c.rows]
            checked += len(c.rows) + (c.code is not None)
            wrong += bool(faults)
            for fault in faults:
                print(f"{c.name}: {fault}")
    print(f"{len(chosen)} cases, {checked} checks, {wrong} cases wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
