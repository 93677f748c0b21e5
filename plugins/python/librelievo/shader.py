"""Exploration of shaders that the host runs itself: marks, augmented texts, and membership by examples."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy

from . import abi, library, record
from .array import Reading, address, flag, number, packed, writing
from .error import Invalid, shown
from .handle import Handle, text_bytes
from .hint import Array, ArrayLike
from .parameter import address_of


class ShaderExamples:
    """Classified pixels: vectors (n, features) with a class each, and how others are compared with them."""

    def __init__(self, vectors: ArrayLike, classes: Any, exponent: float = 2.0, is_scaled: bool = False) -> None:
        """`classes` are values of ShaderClass or truth values, true for what is sought."""
        self.vectors = packed(vectors, numpy.float32, "vectors")
        self.classes = packed(classes, numpy.uint32, "classes")
        if self.vectors.ndim != 2 or self.classes.shape != self.vectors.shape[:1]:
            raise Invalid(f"vectors: the shape (n, features) and n classes are needed, not {self.vectors.shape}")
        self.record = record.empty(abi.RlvShaderExamples)
        self.record.count, self.record.feature_count = self.vectors.shape
        self.record.vectors, self.record.classes = address(self.vectors), address(self.classes)
        self.record.exponent, self.record.is_scaled = number(exponent, "exponent"), flag(is_scaled, "is_scaled")

    def pack(self, mode: Any = abi.RlvShaderMode.RENDER, x: int = 0, y: int = 0) -> Any:
        """The words of the buffer of examples: to render, to classify the pixel (x, y), or for a mask of x by y pixels."""
        count = ctypes.c_size_t()
        arguments = ctypes.byref(self.record), record.named(abi.RlvShaderMode, mode, "mode"), x, y
        library.call("rlv_shader_pack_examples", *arguments, None, 0, address_of(count))
        words, place, _ = writing(None, count.value, numpy.uint32, 0, "words")
        library.call("rlv_shader_pack_examples", *arguments, place, len(words), address_of(count))
        return words

    def membership(self, vectors: ArrayLike) -> Array:
        """The degree, 0 to 1, to which each of the vectors (n, features) resembles the positive examples."""
        vectors = Reading(vectors, numpy.float32, self.record.feature_count, "vectors")
        out, place, _ = writing(None, vectors.count, numpy.float32, 0, "out")
        library.call("rlv_shader_membership", ctypes.byref(self.record), vectors.address, vectors.count, vectors.stride, place)
        return out


class Shader(Handle):
    """A shader that was read, and augmented if it has a mark `vector`."""

    noun, kind = "shader", abi.RlvShader

    def __init__(self, source: Any, language: str = "glsl", stage: str = "fragment", name: str | None = None) -> None:
        """`language` is "glsl" or "wgsl"; `stage` of GLSL is "vertex", "fragment" or "compute"."""
        enums = {"language": abi.RlvShaderLanguage, "stage": abi.RlvShaderStage}
        options = record.fill(abi.RlvShaderOptions, {"language": language, "stage": stage}, **enums)
        options.name = text_bytes(name, "name")
        super().__init__("rlv_shader_create", text_bytes(source, "source"), ctypes.byref(options))

    def variables(self) -> list[Any]:
        """The float variables in the order of the text."""
        count = ctypes.c_size_t()
        library.call("rlv_shader_variable_count", self.handle, address_of(count))
        return [self._read("rlv_shader_variable", abi.RlvShaderVariable, index) for index in range(count.value)]

    def mark(self, *names: str, weight: str = "1.0") -> Shader:
        """The shader with a mark that takes a vector of variables; those declared last have the names."""
        variables = self.variables()
        chosen = numpy.empty(len(names), numpy.uint32)
        for place, name in enumerate(names):
            found = [index for index, variable in enumerate(variables) if variable.name == name] if isinstance(name, str) else []
            if not found:
                raise Invalid(f"names: {shown(name)} is no float variable; there are {', '.join(it.name for it in variables)}")
            chosen[place] = found[-1]
        return Shader.of("rlv_shader_mark", self.handle, address(chosen), len(chosen), text_bytes(weight, "weight"))

    def text(self, kind: str = "augmented") -> Any:
        """A text of the shader: "marked", "augmented" or "augmented_wgsl"."""
        kind = record.named(abi.RlvShaderText, kind, "kind")
        length = ctypes.c_size_t()
        library.call("rlv_shader_text", self.handle, kind, None, 0, address_of(length))
        text = ctypes.create_string_buffer(length.value + 1)
        library.call("rlv_shader_text", self.handle, kind, text, len(text), address_of(length))
        return text.value.decode("utf-8")

    def layout(self) -> Any:
        """Where the augmented shader finds its buffers, and how many features its vectors have."""
        return self._read("rlv_shader_layout", abi.RlvShaderLayout)

    def features(self) -> list[Any]:
        """The features of the vectors: name, expression and description."""
        indices = range(self.layout().feature_count)
        return [self._read("rlv_shader_feature", abi.RlvShaderFeature, index) for index in indices]

    def unpack(self, log: Any) -> Any:
        """The vector of the pixel that wrote a log, whose words are an array."""
        words = Reading(packed(log, None, "log"), numpy.uint32, 0, "log").array
        vector, place, _ = writing(None, self.layout().feature_count, numpy.float32, 0, "vector")
        library.call("rlv_shader_unpack_log", self.handle, address(words), len(words), place, len(vector), None)
        return vector

    def _read(self, function: str, kind: Any, *arguments: Any) -> Any:
        found = record.empty(kind)
        library.call(function, self.handle, *arguments, ctypes.byref(found))
        return record.read(found)
