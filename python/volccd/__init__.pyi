# Types of the package; `help(volccd)` and docs/python.md explain it. python/tests/test_docs.py holds it to the code.
from os import PathLike
from types import SimpleNamespace
from typing import Any, ClassVar, Dict, Iterable, Iterator, List, Literal, Mapping, NamedTuple, Optional
from typing import Sequence as _Sequence, SupportsIndex, Tuple, Type, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import distributed as distributed

__version__: str

VF: int
EE: int
KEEP: int
DISJOINT: int
CONTACT_FREE: int
CELL_TYPES: Dict[str, int]
contact_dtype: np.dtype[np.void]
pair_dtype: np.dtype[np.void]

_Points = Any  # npt.ArrayLike (n, 3), meshio.Mesh or pyvista.UnstructuredGrid
_Cells = Any  # npt.ArrayLike (m, k), pairs, dict, blocks of meshio, vtk_cells()
_Setting = Union[str, int, float, bool, None]
_Settings = Union[str, _Sequence[str], Mapping[str, Union[_Setting, _Sequence[_Setting]]]]
_Pairs = Literal["all", "inter", "intra"]
_Edges = Literal["triangulated", "polytope"]
_Path = Union[str, PathLike[str]]

class Error(RuntimeError): ...

class InputError(Error, ValueError):
    source: str
    dataset: str
    index: Optional[int]

class ConfigError(Error, ValueError): ...

class Result:
    @property
    def contacts(self) -> npt.NDArray[np.void]: ...
    @property
    def ends(self) -> npt.NDArray[np.void]: ...
    @property
    @property
    def initial_overlaps(self) -> npt.NDArray[np.void]: ...
    @property
    def statistics(self) -> Dict[str, Any]: ...
    @property
    def earliest(self) -> float: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Contact]: ...
    def __getitem__(self, index: SupportsIndex) -> Contact: ...
    def to_frame(self) -> Any: ...  # pandas.DataFrame
    def to_meshio(self) -> Any: ...  # meshio.Mesh
    def to_pyvista(self) -> Any: ...  # pyvista.PolyData

class Contact(NamedTuple):
    kind: int
    vertices: Tuple[int, ...]
    toi: float
    normal: npt.NDArray[np.float64]
    point: npt.NDArray[np.float64]
    weights: npt.NDArray[np.float64]
    at_start: bool
    gap: float

def vtk_cells(connectivity: npt.ArrayLike, offsets: npt.ArrayLike, types: npt.ArrayLike) -> Dict[str, Any]: ...
def detect(points0: _Points, points1: _Points, cells: _Cells = ..., pipeline: str = ..., separation: float = ..., *,
           middle: Optional[npt.ArrayLike] = ..., objects: Optional[npt.ArrayLike] = ...,
           ids: Optional[npt.ArrayLike] = ..., thickness: Optional[npt.ArrayLike] = ..., threads: int = ...,
           first: bool = ..., initial_overlaps: bool = ..., t_max: float = ..., pairs: _Pairs = ...,
           exclude: Iterable[Tuple[int, int]] = ..., edges: _Edges = ..., settings: _Settings = ...) -> Result: ...

class Detector:
    def __init__(self, cells: _Cells, vertices: Optional[int] = ..., *, objects: Optional[npt.ArrayLike] = ...,
                 ids: Optional[npt.ArrayLike] = ..., thickness: Optional[npt.ArrayLike] = ..., pipeline: str = ...,
                 separation: float = ..., threads: int = ..., settings: _Settings = ..., pairs: _Pairs = ...,
                 exclude: Iterable[Tuple[int, int]] = ..., edges: _Edges = ...,
                 lists: Union[str, Tuple[float, float]] = ...) -> None: ...
    def step(self, points0: npt.ArrayLike, points1: npt.ArrayLike, middle: Optional[npt.ArrayLike] = ..., *,
             first: bool = ..., initial_overlaps: bool = ..., t_max: float = ..., ends: bool = ...) -> Result: ...
    def edit(self, remove: npt.ArrayLike = ..., add: _Cells = ..., *, new_vertices: int = ...,
             objects: Optional[npt.ArrayLike] = ..., ids: Optional[npt.ArrayLike] = ...,
             thickness: Optional[npt.ArrayLike] = ...) -> npt.NDArray[np.int64]: ...
    separation: float
    @property
    def element_ids(self) -> npt.NDArray[np.int64]: ...
    @property
    def vertex_count(self) -> int: ...
    @property
    def element_count(self) -> int: ...
    @property
    def facts(self) -> Dict[str, Any]: ...

class Sequence:
    shells: str
    def __init__(self, path: _Path, *, shells: Literal["surface", "solid"] = ...,
                 motion: Literal["linear", "quadratic", "tentative", "query"] = ..., edges: _Edges = ...,
                 objects: Literal["stored", "components"] = ...) -> None: ...
    def __len__(self) -> int: ...
    @property
    def path(self) -> str: ...
    @property
    def frame_count(self) -> int: ...
    @property
    def point_count(self) -> int: ...
    @property
    def point_ids(self) -> npt.NDArray[np.int64]: ...
    @property
    def times(self) -> npt.NDArray[np.float64]: ...
    @property
    def metadata(self) -> Dict[str, Any]: ...
    @property
    def element_ids(self) -> npt.NDArray[np.int64]: ...
    def points(self, frame: int) -> npt.NDArray[np.float64]: ...
    def velocity(self, frame: int) -> Optional[npt.NDArray[np.float64]]: ...
    def thickness(self, frame: int) -> Optional[npt.NDArray[np.float64]]: ...
    def cells(self, frame: int) -> Dict[str, Any]: ...
    def detect(self, steps: Optional[Iterable[int]] = ..., *, pipeline: str = ..., separation: float = ...,
               threads: int = ..., first: bool = ..., initial_overlaps: bool = ..., t_max: float = ...,
               pairs: _Pairs = ..., exclude: Iterable[Tuple[int, int]] = ..., settings: _Settings = ...,
               shell_neighbours: bool = ...) -> Iterator[Tuple[int, Result]]: ...

def scenes() -> Dict[str, str]: ...
def scene(name: str, *, simulate: bool = ..., threads: int = ..., **options: Any) -> Sequence: ...

class Verification:
    steps: List[Dict[str, Any]]
    skipped: List[str]
    def __init__(self, steps: List[Dict[str, Any]], skipped: List[str]) -> None: ...
    @property
    def clean(self) -> bool: ...
    @property
    def differing(self) -> List[str]: ...
    def __bool__(self) -> bool: ...

def verify(sequence: Union[Sequence, _Path], steps: Optional[Iterable[int]] = ..., *, settings: _Settings = ...,
           threads: int = ..., separation: float = ..., fcl: bool = ..., approximate: bool = ...,
           brute_force_limit: int = ...) -> Verification: ...

class Step:
    control_points: npt.NDArray[np.float64]
    corners: npt.NDArray[np.uint32]
    types: npt.NDArray[np.uint8]
    objects: npt.NDArray[np.int32]
    separation: float
    t_max: float
    state: SimpleNamespace
    @property
    def x0(self) -> npt.NDArray[np.float64]: ...
    @property
    def x1(self) -> npt.NDArray[np.float64]: ...
    def element_points(self, elements: npt.ArrayLike) -> npt.NDArray[np.float64]: ...
    def element_bounds(self) -> Tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]: ...

class Stage:
    name: ClassVar[Optional[str]]
    role: ClassVar[Optional[str]]
    guarantee: ClassVar[str]
    options: ClassVar[Mapping[str, Any]]
    def prepare(self, step: Step) -> None: ...

class ElementCulling(Stage):
    def cull(self, step: Step, pairs: npt.NDArray[np.uint32]) -> npt.NDArray[Any]: ...

class FeatureFilter(Stage):
    def filter(self, step: Step, kind: int, vertices: npt.NDArray[np.uint32],
               points: npt.NDArray[np.float64]) -> npt.NDArray[Any]: ...

class NarrowPhase(Stage):
    max_control_points: ClassVar[int]
    handles_separation: ClassVar[bool]
    time_tolerance: ClassVar[float]
    def test(self, step: Step, kind: int, vertices: npt.NDArray[np.uint32],
             points: npt.NDArray[np.float64]) -> Union[npt.NDArray[np.float64], Dict[str, npt.NDArray[Any]]]: ...

_StageType = TypeVar("_StageType", bound=Type[Stage])

def register(stage: _StageType) -> _StageType: ...
def unregister(name: str) -> None: ...
def add_pipeline(name: str, base: str = ..., settings: _Settings = ..., description: str = ...) -> None: ...
def stages() -> List[Dict[str, Any]]: ...
def pipelines() -> Dict[str, str]: ...
def main(argv: Optional[_Sequence[str]] = ...) -> int: ...
def read_record(path: _Path) -> Dict[str, Any]: ...
def records(path: _Path) -> Any: ...
