"""Policies on a Hailo: their convolutions run there as `encoder.hef`, by HailoRT's C interface, the rest here.

Not run on a Hailo: the tests play its library.
"""

from __future__ import annotations

import ctypes
import os
import threading
import weakref
from contextlib import ExitStack
from ctypes import POINTER, byref, c_bool, c_char_p, c_int, c_size_t, c_uint8, c_uint32, c_void_p
from ctypes.util import find_library
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe.ai.engine import GraphEngine
from threewe.ai.folder import ENCODER, FEATURES, Policy, image_input
from threewe.errors import ConfigError, HardwareError

LIBRARY = "THREEWE_HAILORT"
"""Environment variable: the path of the library, where the system does not find it."""
UINT8, FLOAT32 = 1, 3
"""hailo_format_type_t"""
STREAM_PARAMS = 128 + 7 * 4
"""[bytes] of hailo_input_vstream_params_by_name_t, and of the same for outputs; filled and read by the library alone"""
MOST_STREAMS = 4


class HailoEngine:
    """Computes features on a Hailo, and actions from them here."""

    def __init__(self, policy: Policy, head: bytes) -> None:
        """Loads the library and configures the device. Raises ConfigError, HardwareError."""
        assert policy.features is not None
        camera, (channels, height, width) = policy.cameras[0], policy.features
        self._picture = image_input(camera.name)
        self._features = height, width, channels
        self._head = GraphEngine(policy, head)
        self._device = _Device(policy.folder / ENCODER, camera.height * camera.width * 3, 4 * channels * height * width)
        self._one_at_a_time = threading.Lock()

    def infer(self, feed: dict[str, NDArray[np.float32]], instruction: str) -> NDArray[np.float32]:
        """See `Engine`. Raises HardwareError when the device fails."""
        left = dict(feed)
        pixels = np.rint(left.pop(self._picture)[0].transpose(1, 2, 0) * 255).astype(np.uint8)
        with self._one_at_a_time:
            features = np.frombuffer(self._device.run(np.ascontiguousarray(pixels)), np.float32)
        shaped = features.reshape(self._features).transpose(2, 0, 1)
        return self._head.infer({**left, FEATURES: np.ascontiguousarray(shaped)[None]}, instruction)


class _Device:
    """A `.hef` on a virtual device, one picture at a time."""

    def __init__(self, file: Path, given: int, gives: int) -> None:
        self._library, self._file = _library(), file
        self._buffer = np.empty(gives, np.uint8)
        opened = ExitStack()
        try:
            group = self._configure(opened)
            self._input = self._stream(opened, group, "input", UINT8, given)
            self._output = self._stream(opened, group, "output", FLOAT32, gives)
        except BaseException:
            opened.close()
            raise
        weakref.finalize(self, opened.close)  # or no other policy gets the device

    def _configure(self, opened: ExitStack) -> c_void_p:
        """The network of the file, on a device."""
        library, (device, hef, group), count = self._library, (c_void_p(), c_void_p(), c_void_p()), c_size_t(1)
        self._check("create_vdevice", library.hailo_create_vdevice(None, byref(device)))
        opened.callback(library.hailo_release_vdevice, device)
        self._check("create_hef_file", library.hailo_create_hef_file(byref(hef), os.fsencode(self._file)))
        opened.callback(library.hailo_release_hef, hef)
        status = library.hailo_configure_vdevice(device, hef, None, byref(group), byref(count))
        self._check("configure_vdevice", status)
        return group

    def _stream(self, opened: ExitStack, group: c_void_p, kind: str, form: int, size: int) -> c_void_p:
        """Its one input or output, of so many bytes."""

        def function(name: str) -> Any:
            return getattr(self._library, f"hailo_{name}")

        params, count = (c_uint8 * (MOST_STREAMS * STREAM_PARAMS))(), c_size_t(MOST_STREAMS)
        stream, found = c_void_p(), c_size_t()
        make, create = f"make_{kind}_vstream_params", f"create_{kind}_vstreams"
        self._check(make, function(make)(group, False, form, params, byref(count)))
        if count.value != 1:
            raise ConfigError(f"{self._file}: has {count.value} {kind}s; an encoder has one")
        self._check(create, function(create)(group, params, 1, byref(stream)))
        opened.callback(function(f"release_{kind}_vstreams"), byref(stream), 1)
        measure = f"get_{kind}_vstream_frame_size"
        self._check(measure, function(measure)(stream, byref(found)))
        if found.value != size:
            raise ConfigError(f"{self._file}: its {kind} is {found.value} bytes; policy.json says {size}")
        return stream

    def run(self, pixels: NDArray[np.uint8]) -> memoryview:
        """The bytes of the features of a picture (H, W, 3)."""
        library, buffer = self._library, self._buffer
        status = library.hailo_vstream_write_raw_buffer(self._input, pixels.ctypes.data_as(c_void_p), pixels.nbytes)
        self._check("vstream_write_raw_buffer", status)
        status = library.hailo_vstream_read_raw_buffer(self._output, buffer.ctypes.data_as(c_void_p), buffer.nbytes)
        self._check("vstream_read_raw_buffer", status)
        return buffer.copy().data

    def _check(self, what: str, status: int) -> None:
        if status != 0:
            words = self._library.hailo_get_status_message(status)
            raise HardwareError(f"{self._file}: hailo_{what}: {(words or b'').decode()} (status {status})")


FUNCTIONS: dict[str, list[Any]] = {
    "create_vdevice": [c_void_p, POINTER(c_void_p)],
    "create_hef_file": [POINTER(c_void_p), c_char_p],
    "configure_vdevice": [c_void_p, c_void_p, c_void_p, POINTER(c_void_p), POINTER(c_size_t)],
    "make_input_vstream_params": [c_void_p, c_bool, c_int, c_void_p, POINTER(c_size_t)],
    "make_output_vstream_params": [c_void_p, c_bool, c_int, c_void_p, POINTER(c_size_t)],
    "create_input_vstreams": [c_void_p, c_void_p, c_size_t, POINTER(c_void_p)],
    "create_output_vstreams": [c_void_p, c_void_p, c_size_t, POINTER(c_void_p)],
    "get_input_vstream_frame_size": [c_void_p, POINTER(c_size_t)],
    "get_output_vstream_frame_size": [c_void_p, POINTER(c_size_t)],
    "vstream_write_raw_buffer": [c_void_p, c_void_p, c_size_t],
    "vstream_read_raw_buffer": [c_void_p, c_void_p, c_size_t],
    "release_input_vstreams": [POINTER(c_void_p), c_size_t],
    "release_output_vstreams": [POINTER(c_void_p), c_size_t],
    "release_hef": [c_void_p],
    "release_vdevice": [c_void_p],
    "get_library_version": [POINTER(c_uint32 * 3)],
}
"""The arguments of those that are called, without `hailo_`; each returns a status (hailort.h, 4.17 to 4.22)."""


def _library() -> Any:
    """HailoRT 4.x. Raises ConfigError."""
    path = os.environ.get(LIBRARY) or find_library("hailort")
    missing = "a policy with an encoder.hef needs HailoRT 4.x, Hailo's own library"
    if path is None:
        raise ConfigError(f"{missing}: libhailort.so is not installed here; {LIBRARY}= names one elsewhere")
    try:
        library = ctypes.CDLL(path)
        for name, arguments in FUNCTIONS.items():
            getattr(library, f"hailo_{name}").argtypes = arguments
        library.hailo_get_status_message.argtypes = [c_int]
        library.hailo_get_status_message.restype = c_char_p
    except (OSError, AttributeError) as error:
        raise ConfigError(f"{missing}: {path} is none: {error}") from None
    version = (c_uint32 * 3)()
    library.hailo_get_library_version(byref(version))
    if version[0] != 4:
        raise ConfigError(f"{missing}: {path} is {'.'.join(map(str, version))}")
    return library
