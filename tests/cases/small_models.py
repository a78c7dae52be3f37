"""Builders of small models, byte by byte, for public_cases.py. Unless they say otherwise they make the unit
square of two triangles: area 1, box 0 0 0 1 1 0."""
import base64
import io
import json
import struct
import zipfile
import zlib

SQUARE = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
HALVES = ((0, 1, 2), (0, 2, 3))


def rows(values):
    return "".join(" ".join(str(v) for v in row) + "\n" for row in values)


def png(width, height, pixels, color_type=2, depth=8, palette=None):
    """pixels: the bytes of all rows, without filter bytes."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    stride = len(pixels) // height
    lines = b"".join(b"\0" + pixels[y * stride:(y + 1) * stride] for y in range(height))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, color_type, 0, 0, 0)) +
            (chunk(b"PLTE", palette) if palette else b"") + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b""))


def plain_png(r, g, b):
    return png(2, 2, bytes((r, g, b)) * 4)


def two_png(left, right):
    """16 x 1 pixels, the left half of one color and the right of another."""
    return png(16, 1, bytes(left) * 8 + bytes(right) * 8)


def ply(elements, body, encoding="ascii", comments=(), end="\n"):
    """elements: lines of the header behind the format; body: text or bytes."""
    lines = ["ply", f"format {encoding} 1.0", *comments, *elements, "end_header", ""]
    return end.join(lines).encode() + (body if isinstance(body, bytes) else body.encode())


XYZ = ["property float x", "property float y", "property float z"]


def square_ply(index="property list uchar int vertex_indices", face=None, encoding="ascii", vertex=(), comments=(),
     end="\n",
               vertex_row=None):
    """face, vertex_row: how one triangle, one vertex is packed."""
    header = ["element vertex 4", *XYZ, *vertex, "element face 2", index]
    if encoding == "ascii":
        body = "".join(" ".join(map(str, (vertex_row or (lambda v: v))(v))) + end for v in SQUARE)
        body += "".join(" ".join(map(str, (face or (lambda t: (3, *t)))(t))) + end for t in HALVES)
        return ply(header, body, encoding, comments, end)
    order = "<" if "little" in encoding else ">"
    body = b"".join(vertex_row(v) if vertex_row else struct.pack(order + "3f", *v) for v in SQUARE)
    body += b"".join(face(t) if face else struct.pack(order + "B3i", 3, *t) for t in HALVES)
    return ply(header, body, encoding, comments, end)


def off(keyword="OFF", counts="4 2 0", vertices=SQUARE, faces=((3, 0, 1, 2), (3, 0, 2, 3))):
    return (f"{keyword}\n{counts}\n" + rows(vertices) + rows(faces)).encode()


OBJ_VERTICES = rows(("v", *v) for v in SQUARE)
OBJ_COORDINATES = rows(("vt", *v[:2]) for v in SQUARE)


def obj(faces, before="", between=""):
    return (before + OBJ_VERTICES + OBJ_COORDINATES + between + faces).encode()


def textured(mtl, between="usemtl m\n", library="model.mtl", faces="f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"):
    return {"model.obj": obj(faces, f"mtllib {library}\n", between),
            library: mtl if isinstance(mtl, bytes) else mtl.encode()}


def ascii_stl(name="", first="", between="", facet="facet normal 0 0 1", vertex="vertex {} {} {}", end="endsolid",
     solid="solid",
              eol="\n"):
    lines = [f"{solid} {name}".rstrip(), *([first] if first else [])]
    for t in HALVES:
        lines += [facet, "outer loop", *(vertex.format(*SQUARE[c]) for c in t), "endloop", "endfacet"]
        lines += [between] if between else []
    return (eol.join(lines + [end]) + eol).encode()


def binary_stl(header=b"", count=2, attribute=0, normal=(0, 0, 1), rest=b""):
    facets = b"".join(struct.pack("<3f", *normal) + b"".join(struct.pack("<3f", *SQUARE[c]) for c in t) +
                      struct.pack("<H", attribute) for t in HALVES)
    return header.ljust(80, b"\0")[:80] + struct.pack("<I", count) + facets + rest


def zipped(members, host=3):
    """host: of the archive by its format, 0 for Windows and 3 for Unix."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            member = zipfile.ZipInfo()
            member.filename, member.create_system, member.compress_type = name, host, zipfile.ZIP_DEFLATED
            archive.writestr(member, data)
    return packed.getvalue()


COMPONENTS = {"b": 5120, "B": 5121, "h": 5122, "H": 5123, "I": 5125, "f": 5126}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Gltf:
    """A glTF document that grows: accessors are appended to one buffer."""

    def __init__(self):
        self.buffer = b""
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "meshes": [{"primitives": [{"attributes": {}}]}], "accessors": [], "bufferViews": []}

    @property
    def primitive(self):
        return self.json["meshes"][0]["primitives"][0]

    def view(self, data, **more):
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data), **more})
        self.buffer += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, code, kind, values, pad=0, **more):
        width = WIDTHS[kind]
        packed = b"".join(struct.pack("<" + code * width, *values[i:i + width]) + b"\xff" * pad
                          for i in range(0, len(values), width))
        stride = {"byteStride": len(packed) * width // len(values)} if pad else {}
        view = self.view(packed, **stride)
        self.json["accessors"].append({"bufferView": view, "componentType": COMPONENTS[code], "type": kind,
                                       "count": len(values) // width, **more})
        return len(self.json["accessors"]) - 1

    def positions(self, vertices=SQUARE, code="f", pad=0, **more):
        flat = [c for v in vertices for c in v]
        bounds = {"min": [min(flat[k::3]) for k in range(3)], "max": [max(flat[k::3]) for k in range(3)]}
        return self.accessor(code, "VEC3", flat, pad, **bounds, **more)

    def square(self, index="H", **more):
        self.primitive["attributes"]["POSITION"] = self.positions(**more)
        if index:
            self.primitive["indices"] = self.accessor(index, "SCALAR", [c for t in HALVES for c in t])
        return self

    def coordinates(self, name="TEXCOORD_0", values=None):
        flat = values or [c for v in SQUARE for c in v[:2]]
        self.primitive["attributes"][name] = self.accessor("f", "VEC2", flat)
        return self

    def material(self, **material):
        self.json["materials"] = [material]
        self.primitive["material"] = 0
        return self

    def texture(self, image, sampler=None, **info):
        """A material whose base color is the image."""
        self.json["images"] = [{"bufferView": self.view(image), "mimeType": "image/png"}]
        self.json["textures"] = [{"source": 0, **({"sampler": 0} if sampler else {})}]
        if sampler:
            self.json["samplers"] = [sampler]
        return self.material(pbrMetallicRoughness={"baseColorTexture": {"index": 0, **info}})

    def set(self, **values):
        self.json.update(values)
        return self

    def without(self, *names):
        for name in names:
            del self.json[name]
        return self

    def document(self, uri=None):
        buffer = {"byteLength": len(self.buffer), **({"uri": uri} if uri is not None else {})}
        return json.dumps({**self.json, "buffers": [buffer, *self.json.get("buffers", [])[1:]]})

    def gltf(self, uri=None, head="data:application/octet-stream;base64,"):
        """With the buffer in the file, or named by its uri."""
        return self.document(uri if uri is not None else head + base64.b64encode(self.buffer).decode()).encode()

    def glb(self, pad=b" ", uri=None, rest=b"", extra=b"", version=2, stated=0):
        text = self.document(uri).encode()
        text += pad * (-len(text) % 4)
        data = self.buffer + b"\0" * (-len(self.buffer) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + extra
        if uri is None:
            chunks += struct.pack("<II", len(data), 0x004E4942) + data
        return struct.pack("<III", 0x46546C67, version, 12 + len(chunks) + stated) + chunks + rest
