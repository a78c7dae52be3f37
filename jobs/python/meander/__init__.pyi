import os
from typing import Any, Callable, Dict, Iterable, Iterator, List, Literal, Mapping, Optional, Sequence, Union, overload

import numpy
from numpy.typing import ArrayLike, NDArray

from .neighbors import Neighbors as Neighbors, knn as knn
from .store import Store as Store, StoreDataset as StoreDataset, open_store as open_store

__version__: str

MethodWord = Literal["auto", "conformal", "direct", "anisotropic"]
SequenceWord = Literal["shifted", "stratified", "owen", "regular", "random", "spaced"]
SpacingWord = Literal["fast", "default", "best"]
FinishWord = Literal["none", "relax"]
OrderWord = Literal["progressive", "curve"]
CurveWord = Literal["hilbert", "peano", "peano-meander", "balanced"]
NormalizeWord = Literal["none", "unit-sphere", "unit-box", "unit-diagonal", "pointnet"]
SharpFillWord = Literal["surface", "nan"]
QueriesMoveWord = Literal["gaussian", "uniform", "along-normal"]
SignWord = Literal["auto", "closed", "winding", "shell", "none"]
QueriesTypeWord = Literal["float32", "float16"]
Content = Union[bytes, str, None]
Path = Union[str, "os.PathLike[str]"]
Value = Union[str, float, "os.PathLike[str]", Sequence[Union[str, "os.PathLike[str]"]]]
Place = Literal["vertices", "faces"]
Function = Callable[[NDArray[numpy.float64]], ArrayLike]

class Mesh:
    @staticmethod
    def read(path: str) -> Mesh: ...
    @property
    def vertices(self) -> NDArray[numpy.float64]: ...
    @property
    def faces(self) -> Optional[NDArray[numpy.uint32]]: ...
    @property
    def content(self) -> bytes: ...

class SamplingError(RuntimeError):
    status: str
    reason: str
    index: Optional[int]
    def __init__(self, status: str, reason: str, index: Optional[int] = None) -> None: ...

class Samples:
    points: NDArray[numpy.float32]
    normals: NDArray[numpy.float32]
    uv: Optional[NDArray[numpy.float32]]
    face_index: Optional[NDArray[numpy.uint32]]
    corners: Optional[NDArray[numpy.uint32]]
    barycentric: Optional[NDArray[numpy.float32]]
    curve_rank: NDArray[numpy.uint32]
    density: NDArray[numpy.float32]
    tensor_direction: Optional[NDArray[numpy.float32]]
    tensor_spacing: Optional[NDArray[numpy.float32]]
    rgb: Optional[NDArray[numpy.uint8]]
    texcoord: Optional[NDArray[numpy.float32]]
    sharp_points: Optional[NDArray[numpy.float32]]
    sharp_normals: Optional[NDArray[numpy.float32]]
    sharp_tangents: Optional[NDArray[numpy.float32]]
    sharp_edge: Optional[NDArray[numpy.uint32]]
    queries_points: Optional[NDArray[numpy.float32]]
    queries_kind: Optional[NDArray[numpy.uint8]]
    queries_distance: Optional[NDArray[numpy.float32]]
    queries_inside: Optional[NDArray[numpy.uint8]]
    queries_winding: Optional[NDArray[numpy.float32]]
    queries_sign_certain: Optional[NDArray[numpy.uint8]]
    queries_face: Optional[NDArray[numpy.uint32]]
    queries_corners: Optional[NDArray[numpy.uint32]]
    queries_barycentric: Optional[NDArray[numpy.float32]]
    weights: NDArray[numpy.float64]
    attributes: Dict[str, NDArray[Any]]
    names: Dict[str, List[str]]
    color_source: str
    color_fills: int
    notes: Dict[str, int]
    note_text: str
    descriptors: Dict[str, NDArray[numpy.float32]]
    area: float
    measure: float
    bbox: NDArray[numpy.float64]
    loc: NDArray[numpy.float64]
    scale: float
    method: str
    components: int
    genus: int
    boundaries: int
    repairs: Dict[str, int]
    sharp_edges: int
    sharp_length: float
    sign_rule: str
    uncertain: int
    content: bytes
    def __len__(self) -> int: ...
    def coordinates(self) -> NDArray[numpy.float64]: ...
    def interpolate(self, values: ArrayLike) -> NDArray[numpy.float64]: ...

class RunStopped(RuntimeError): ...

class RunResult:
    store: str
    items: int
    samples: int
    done_now: int
    seconds: float
    status: Dict[str, int]
    failed: List[Dict[str, str]]
    notes: Dict[str, int]
    exit_status: int
    def __getattr__(self, name: str) -> Any: ...

def run(inputs: Union[Path, Iterable[Path]], store: Path, *,
        progress: Optional[Callable[[int, int, Dict[str, Any]], Any]] = None, n: Optional[Union[int, str]] = None,
        method: Optional[Literal["auto", "conformal", "direct", "anisotropic"]] = None, density: Optional[Value] = None,
        density_floor: Optional[float] = None, density_exponent: Optional[float] = None,
        locate: Optional[Literal["embree", "elements", "first-hit"]] = None,
        place: Optional[Literal["element", "vertex"]] = None,
        sequence: Optional[Literal["shifted", "stratified", "owen", "regular", "random", "spaced"]] = None,
        spacing: Optional[Literal["fast", "default", "best"]] = None, finish: Optional[Literal["none", "relax"]] = None,
        order: Optional[Literal["progressive", "curve"]] = None,
        curve: Optional[Literal["hilbert", "peano", "peano-meander", "balanced"]] = None,
        seed: Optional[Union[int, str]] = None,
        normalize: Optional[Literal["none", "unit-sphere", "unit-box", "unit-diagonal", "pointnet"]] = None,
        curved: bool = False, tensor: Optional[Value] = None,
        tensor_form: Optional[Literal["spacing", "metric"]] = None, tensor_ratio: Optional[float] = None,
        tensor_density: Optional[Literal["keep", "follow"]] = None, tensor_smoothing: Optional[Union[int, str]] = None,
        parameterization: Optional[Literal["metric", "gradient"]] = None, segments: Optional[Union[int, str]] = None,
        topology: Optional[bool] = None, describe: Optional[Value] = None, bins: Optional[Union[int, str]] = None,
        descriptor_scale: Optional[Literal["mean", "largest"]] = None,
        geodesic_sources: Optional[Union[int, str]] = None, strict: Optional[Value] = None, certify: bool = False,
        compress: Optional[Literal["default", "none"]] = None, colors: bool = False, texcoord: bool = False,
        attributes: Optional[Value] = None, columns: Optional[Value] = None, root: Optional[Value] = None,
        null: bool = False, layout: Optional[Literal["auto", "flat", "modelnet", "shapenet"]] = None,
        labels: Optional[Value] = None, label_from_folder: bool = False, sharp: Optional[Union[int, str]] = None,
        sharp_angle: Optional[float] = None, sharp_borders: bool = False, sharp_corners: bool = False,
        sharp_attribute: Optional[Value] = None, sharp_fill: Optional[Literal["surface", "nan"]] = None,
        queries: Optional[Value] = None, queries_move: Optional[Literal["gaussian", "uniform", "along-normal"]] = None,
        queries_cut: Optional[float] = None,
        sign: Optional[Literal["auto", "closed", "winding", "shell", "none"]] = None,
        queries_type: Optional[Literal["float32", "float16"]] = None, queries_nearest: bool = False,
        threads: Optional[Union[int, str]] = None, memory: Optional[Value] = None, allow_oversize: bool = False,
        timeout: Optional[Value] = None, max_failures: Optional[Union[int, str]] = None, retry: Optional[Value] = None,
        reuse: Optional[Value] = None, trust: bool = False, fresh: bool = False) -> RunResult: ...
def sample(vertices: Any, faces: Optional[ArrayLike] = None, n: int = 2048, *,
           density: Union[str, ArrayLike, Function] = "uniform", density_at: Optional[Place] = None,
           normals: Optional[ArrayLike] = None, colors: Optional[ArrayLike] = None, colors_at: Optional[Place] = None,
           attributes: Optional[Mapping[str, ArrayLike]] = None, attributes_at: Optional[Place] = None,
           topology: bool = True, describe: Union[str, Sequence[str]] = (), content: Content = None, check: bool = True,
           threads: int = 0, timeout: Optional[float] = None, method: MethodWord = "auto", density_floor: float = 0.02,
           density_exponent: float = 1.0, sequence: SequenceWord = "shifted", spacing: SpacingWord = "default",
           finish: FinishWord = "none", order: OrderWord = "progressive", curve: Optional[CurveWord] = None,
           seed: int = 1, normalize: NormalizeWord = "none", curved: bool = False, sharp: Optional[int] = None,
           sharp_angle: float = 30.0, sharp_borders: bool = False, sharp_corners: bool = False,
           sharp_attribute: Optional[str] = None, sharp_fill: SharpFillWord = "surface", queries: Optional[str] = None,
           queries_move: QueriesMoveWord = "gaussian", queries_cut: float = 0.0, sign: SignWord = "auto",
           queries_type: QueriesTypeWord = "float32", queries_nearest: bool = False, bins: int = 32) -> Samples: ...
def sample_file(path: Path, n: int = 2048, *, density: Union[str, ArrayLike, Function] = "uniform",
                density_at: Optional[Place] = None, describe: Union[str, Sequence[str]] = (), threads: int = 0,
                timeout: Optional[float] = None, method: MethodWord = "auto", density_floor: float = 0.02,
                density_exponent: float = 1.0, sequence: SequenceWord = "shifted", spacing: SpacingWord = "default",
                finish: FinishWord = "none", order: OrderWord = "progressive", curve: Optional[CurveWord] = None,
                seed: int = 1, normalize: NormalizeWord = "none", curved: bool = False, colors: bool = False,
                texcoord: bool = False, attributes: Union[str, Sequence[str]] = (), sharp: Optional[int] = None,
                sharp_angle: float = 30.0, sharp_borders: bool = False, sharp_corners: bool = False,
                sharp_attribute: Optional[str] = None, sharp_fill: SharpFillWord = "surface",
                queries: Optional[str] = None, queries_move: QueriesMoveWord = "gaussian", queries_cut: float = 0.0,
                sign: SignWord = "auto", queries_type: QueriesTypeWord = "float32", queries_nearest: bool = False,
                topology: bool = True, bins: int = 32) -> Samples: ...
@overload
def sample_many(meshes: Iterable[Any], n: int = 2048, *, threads: int = 0, errors: Literal["raise"] = "raise",
                density: Union[str, Function] = "uniform", density_at: Optional[Place] = None,
                describe: Union[str, Sequence[str]] = (), check: bool = True, timeout: Optional[float] = None,
                method: MethodWord = "auto", density_floor: float = 0.02, density_exponent: float = 1.0,
                sequence: SequenceWord = "shifted", spacing: SpacingWord = "default", finish: FinishWord = "none",
                order: OrderWord = "progressive", curve: Optional[CurveWord] = None, seed: int = 1,
                normalize: NormalizeWord = "none", curved: bool = False, colors: bool = False, texcoord: bool = False,
                attributes: Union[str, Sequence[str]] = (), sharp: Optional[int] = None, sharp_angle: float = 30.0,
                sharp_borders: bool = False, sharp_corners: bool = False, sharp_attribute: Optional[str] = None,
                sharp_fill: SharpFillWord = "surface", queries: Optional[str] = None,
                queries_move: QueriesMoveWord = "gaussian", queries_cut: float = 0.0, sign: SignWord = "auto",
                queries_type: QueriesTypeWord = "float32", queries_nearest: bool = False, topology: bool = True,
                bins: int = 32) -> Iterator[Samples]: ...
@overload
def sample_many(meshes: Iterable[Any], n: int = 2048, *, threads: int = 0, errors: Literal["return"],
                density: Union[str, Function] = "uniform", density_at: Optional[Place] = None,
                describe: Union[str, Sequence[str]] = (), check: bool = True, timeout: Optional[float] = None,
                method: MethodWord = "auto", density_floor: float = 0.02, density_exponent: float = 1.0,
                sequence: SequenceWord = "shifted", spacing: SpacingWord = "default", finish: FinishWord = "none",
                order: OrderWord = "progressive", curve: Optional[CurveWord] = None, seed: int = 1,
                normalize: NormalizeWord = "none", curved: bool = False, colors: bool = False, texcoord: bool = False,
                attributes: Union[str, Sequence[str]] = (), sharp: Optional[int] = None, sharp_angle: float = 30.0,
                sharp_borders: bool = False, sharp_corners: bool = False, sharp_attribute: Optional[str] = None,
                sharp_fill: SharpFillWord = "surface", queries: Optional[str] = None,
                queries_move: QueriesMoveWord = "gaussian", queries_cut: float = 0.0, sign: SignWord = "auto",
                queries_type: QueriesTypeWord = "float32", queries_nearest: bool = False, topology: bool = True,
                bins: int = 32) -> Iterator[Union[Samples, Exception]]: ...
def describe(vertices: Any, faces: Optional[ArrayLike] = None, descriptors: Union[str, Sequence[str]] = "pairs", *,
             n: int = 1024, seed: int = 1, bins: int = 32, content: Content = None, check: bool = True,
             threads: int = 0, timeout: Optional[float] = None) -> Dict[str, NDArray[numpy.float32]]: ...
def measure(points: ArrayLike, vertices: Any, faces: Optional[ArrayLike] = None, *, boxes: int = 1000,
            seed: int = 1, modes: int = 0) -> Dict[str, float]: ...

class RemeshedMesh:
    vertices: NDArray[numpy.float64]
    faces: NDArray[numpy.uint32]
    samples: int
    report: Dict[str, float]

def remesh(vertices: Any, faces: Optional[ArrayLike] = None, n: int = 2048, *, sequence: SequenceWord = "spaced",
           density: Union[str, ArrayLike, Function] = "uniform", density_at: Optional[Place] = None,
           content: Content = None, check: bool = True, threads: int = 0, timeout: Optional[float] = None,
           crease_angle: float = 40.0, fit: bool = False, method: MethodWord = "auto", density_floor: float = 0.02,
           density_exponent: float = 1.0, spacing: SpacingWord = "default", finish: FinishWord = "none",
           order: OrderWord = "progressive", curve: Optional[CurveWord] = None, seed: int = 1) -> RemeshedMesh: ...

class SignedDistances:
    distance: NDArray[numpy.float64]
    face_index: NDArray[numpy.uint32]
    corners: NDArray[numpy.uint32]
    barycentric: NDArray[numpy.float64]
    inside: NDArray[numpy.bool_]
    certain: NDArray[numpy.bool_]
    winding: Optional[NDArray[numpy.float64]]
    sign: str
    open_edges: int
    def __len__(self) -> int: ...
    def interpolate(self, values: ArrayLike) -> NDArray[numpy.float64]: ...

def signed_distance(vertices: Any, faces: Optional[ArrayLike] = None, points: Optional[ArrayLike] = None, *,
                    sign: Literal["auto", "closed", "winding", "shell", "none"] = "auto", check: bool = True,
                    threads: int = 0, timeout: Optional[float] = None) -> SignedDistances: ...
def winding_number(vertices: Any, faces: Optional[ArrayLike] = None, points: Optional[ArrayLike] = None, *,
                   error: float = 0.05, check: bool = True, threads: int = 0,
                   timeout: Optional[float] = None) -> NDArray[numpy.float64]: ...
class BoxError(float):
    limit: float
    over_limit: float

def measure_boxes(points: ArrayLike, vertices: Any, faces: Optional[ArrayLike] = None, *, boxes: int = 1000,
                  seed: int = 1) -> BoxError: ...
def surface(shape: Union[Path, Callable[[NDArray[numpy.float64], NDArray[numpy.float64]], Any]], n: int = 2048, *,
            tolerance: float = 1e-3, content: Content = None, threads: int = 0, timeout: Optional[float] = None,
            density: str = "uniform", density_floor: float = 0.02, density_exponent: float = 1.0,
            curve: CurveWord = "hilbert", sequence: SequenceWord = "shifted", spacing: SpacingWord = "default",
            finish: FinishWord = "none", order: OrderWord = "progressive", seed: int = 1) -> Samples: ...
def write_points(path: Path, points: Union[Samples, ArrayLike], *, normals: Optional[ArrayLike] = None,
                 colors: Optional[ArrayLike] = None) -> None: ...
def surface_names() -> List[str]: ...
def descriptor_names() -> List[str]: ...
def read_mesh(path: Path) -> Mesh: ...
def content_of(path: Path) -> bytes: ...
