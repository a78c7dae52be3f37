import os
from typing import Any, Callable, Dict, Iterable, List, Literal, Optional, Sequence, Union, overload

import numpy
from numpy.typing import ArrayLike, NDArray

from .store import Store as Store, StoreDataset as StoreDataset, open_store as open_store

__version__: str

MethodWord = Literal["auto", "conformal", "direct", "anisotropic"]
SequenceWord = Literal["shifted", "stratified", "owen", "regular", "random", "spaced"]
SpacingWord = Literal["fast", "default", "best"]
OrderWord = Literal["progressive", "curve"]
CurveWord = Literal["hilbert", "peano", "peano-meander", "balanced"]
NormalizeWord = Literal["none", "unit-sphere", "unit-box", "unit-diagonal", "pointnet"]
Content = Union[bytes, str, None]
Path = Union[str, "os.PathLike[str]"]

class Mesh:
    @staticmethod
    def read(path: str) -> Mesh: ...
    @staticmethod
    def of_arrays(vertices: ArrayLike, faces: ArrayLike, normals: Optional[ArrayLike], density: Optional[ArrayLike],
                  density_of_faces: bool, content: Optional[bytes], check: bool) -> Mesh: ...
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
    weights: NDArray[numpy.float64]
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
    content: bytes
    def __len__(self) -> int: ...
    def coordinates(self) -> NDArray[numpy.float64]: ...
    def interpolate(self, values: ArrayLike) -> NDArray[numpy.float64]: ...

def sample(vertices: Any, faces: Optional[ArrayLike] = None, n: int = 2048, *, density: Union[str,
           ArrayLike] = "uniform", density_at: Optional[Literal["vertices", "faces"]] = None,
           normals: Optional[ArrayLike] = None, topology: bool = True, describe: Union[str, Sequence[str]] = (),
           content: Content = None, check: bool = True, threads: int = 0, timeout: Optional[float] = None,
           method: MethodWord = "auto", density_floor: float = 0.02, density_exponent: float = 1.0,
           sequence: SequenceWord = "shifted", spacing: SpacingWord = "default", order: OrderWord = "progressive",
           curve: Optional[CurveWord] = None, seed: int = 1, normalize: NormalizeWord = "none", curved: bool = False,
           bins: int = 32) -> Samples: ...
@overload
def sample_many(meshes: Iterable[Any], n: int = 2048, *, threads: int = 0, errors: Literal["raise"] = "raise",
                density: str = "uniform", describe: Union[str, Sequence[str]] = (), check: bool = True,
                timeout: Optional[float] = None, method: MethodWord = "auto", density_floor: float = 0.02,
                density_exponent: float = 1.0, sequence: SequenceWord = "shifted", spacing: SpacingWord = "default",
                order: OrderWord = "progressive", curve: Optional[CurveWord] = None, seed: int = 1,
                normalize: NormalizeWord = "none", curved: bool = False, topology: bool = True,
                bins: int = 32) -> List[Samples]: ...
@overload
def sample_many(meshes: Iterable[Any], n: int = 2048, *, threads: int = 0, errors: Literal["return"],
                density: str = "uniform", describe: Union[str, Sequence[str]] = (), check: bool = True,
                timeout: Optional[float] = None, method: MethodWord = "auto", density_floor: float = 0.02,
                density_exponent: float = 1.0, sequence: SequenceWord = "shifted", spacing: SpacingWord = "default",
                order: OrderWord = "progressive", curve: Optional[CurveWord] = None, seed: int = 1,
                normalize: NormalizeWord = "none", curved: bool = False, topology: bool = True,
                bins: int = 32) -> List[Union[Samples, Exception]]: ...
def describe(vertices: Any, faces: Optional[ArrayLike] = None, descriptors: Union[str, Sequence[str]] = "pairs", *,
             n: int = 1024, seed: int = 1, bins: int = 32, content: Content = None, check: bool = True,
             threads: int = 0, timeout: Optional[float] = None) -> Dict[str, NDArray[numpy.float32]]: ...
def measure_boxes(points: ArrayLike, vertices: Any, faces: Optional[ArrayLike] = None, *, boxes: int = 1000,
                  seed: int = 1) -> float: ...
def surface(shape: Union[Path, Callable[[NDArray[numpy.float64], NDArray[numpy.float64]], Any]], n: int = 2048, *,
            tolerance: float = 1e-3, content: Content = None, threads: int = 0, timeout: Optional[float] = None,
            density: str = "uniform", density_floor: float = 0.02, density_exponent: float = 1.0,
            curve: CurveWord = "hilbert", sequence: SequenceWord = "shifted", spacing: SpacingWord = "default",
            order: OrderWord = "progressive", seed: int = 1) -> Samples: ...
def surface_names() -> List[str]: ...
def descriptor_names() -> List[str]: ...
def read_mesh(path: Path) -> Mesh: ...
def content_of(path: Path) -> bytes: ...
