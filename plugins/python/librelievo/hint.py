"""Types of arguments and results, for hints."""

import os
from collections.abc import Callable, Mapping
from typing import Any, Union

import numpy
from numpy.typing import ArrayLike as ArrayLike

# Where a file is.
FilePath = Union[str, bytes, "os.PathLike[Any]"]
# A function of the share that is done, 0 to 1, and the name of the stage; it cancels by returning False.
Progress = Callable[[float, str], Any]
# Fields of a struct of `librelievo.abi` by their names.
Settings = Mapping[str, Any]
# An array of NumPy.
Array = numpy.ndarray[Any, Any]
