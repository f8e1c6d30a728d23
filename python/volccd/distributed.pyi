import dataclasses
from typing import Any, Dict, Iterable, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _Cells, _Edges, _Pairs, _Settings

contact_dtype: np.dtype[Any]

@dataclasses.dataclass(frozen=True)
class Result:
    contacts: npt.NDArray[Any]
    initial_overlaps: npt.NDArray[np.int64]
    statistics: Dict[str, Any]
    rank: Dict[str, Any]
    def __len__(self) -> int: ...

class Detector:
    def __init__(self, comm: Any, cells: _Cells, vertices: npt.ArrayLike, owned: Optional[int] = ..., *,
                 objects: Optional[npt.ArrayLike] = ..., ids: Optional[npt.ArrayLike] = ..., pipeline: str = ...,
                 separation: float = ..., threads: int = ..., settings: _Settings = ..., pairs: _Pairs = ...,
                 exclude: Iterable[tuple[int, int]] = ..., edges: _Edges = ...,
                 lists: Union[str, Tuple[float, float]] = ..., skin: float = ...,
                 max_imbalance: float = ...) -> None: ...
    def set_mesh(self, cells: _Cells, vertices: npt.ArrayLike, owned: Optional[int] = ..., *,
                 objects: Optional[npt.ArrayLike] = ..., ids: Optional[npt.ArrayLike] = ..., edges: _Edges = ...) -> None: ...
    def step(self, points0: npt.ArrayLike, points1: npt.ArrayLike, middle: Optional[npt.ArrayLike] = ..., *,
             first: bool = ..., initial_overlaps: bool = ...) -> Result: ...
    def to_owners(self) -> npt.NDArray[Any]: ...
    separation: float
    @property
    def facts(self) -> Dict[str, Any]: ...
