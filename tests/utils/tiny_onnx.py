"""A network of a kilobyte with the detector model's outputs, written by hand: it finds a red square.

Average pooling by the stride, then a 1x1 convolution: the logit of a cell is red over the other two, its box a square
of constant size. An ONNX file is a protobuf message (github.com/onnx/onnx, `onnx.proto3`), whose wire format is
small enough to be written here, so no test needs the `onnx` package. Regenerate the committed file with

    python -m tests.utils.tiny_onnx drpai/tests/data/red_square.onnx
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

STRIDES = (8, 16, 32)
REACH = {8: 1.5, 16: 2.0, 32: 2.5}
"""Half the side of a box, in strides."""
GAIN, BIAS = 40.0, -12.0
"""logit = GAIN * (red - (green + blue) / 2) + BIAS: zero at 0.3 more red than the others."""
HEIGHT, WIDTH = 256, 320
_FLOAT, _INTS, _INT = 1, 7, 2
"""Of TensorProto.DataType and AttributeProto.AttributeType."""


def _varint(number: int) -> bytes:
    out = bytearray()
    while number > 0x7F:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    out.append(number)
    return bytes(out)


def _int(tag: int, number: int) -> bytes:
    return _varint(tag << 3) + _varint(number)


def _bytes(tag: int, content: bytes | str) -> bytes:
    raw = content.encode() if isinstance(content, str) else content
    return _varint(tag << 3 | 2) + _varint(len(raw)) + raw


def _ints_attribute(name: str, numbers: Sequence[int]) -> bytes:
    return _bytes(1, name) + b"".join(_int(8, n) for n in numbers) + _int(20, _INTS)


def _int_attribute(name: str, number: int) -> bytes:
    return _bytes(1, name) + _int(3, number) + _int(20, _INT)


def _node(kind: str, inputs: Iterable[str], output: str, *attributes: bytes) -> bytes:
    fields = [_bytes(1, name) for name in inputs]
    fields += [_bytes(2, output), _bytes(3, f"{kind}_{output}"), _bytes(4, kind)]
    return b"".join(fields) + b"".join(_bytes(5, attribute) for attribute in attributes)


def _tensor(name: str, shape: Sequence[int], values: Sequence[float]) -> bytes:
    raw = struct.pack(f"<{len(values)}f", *values)
    return b"".join(_int(1, n) for n in shape) + _int(2, _FLOAT) + _bytes(8, name) + _bytes(9, raw)


def _value(name: str, shape: Sequence[int]) -> bytes:
    dimensions = b"".join(_bytes(1, _int(1, n)) for n in shape)
    return _bytes(1, name) + _bytes(2, _bytes(1, _int(1, _FLOAT) + _bytes(2, dimensions)))


def red_square_network(planes: int = 5, strides: Sequence[int] = STRIDES) -> bytes:
    """The file's bytes. Other `planes` make a network that is no detector."""
    nodes, tensors, outputs = [], [], []
    for stride in strides:
        nodes.append(
            _node(
                "AveragePool", ["images"], f"pool{stride}",
                _ints_attribute("kernel_shape", (stride, stride)), _ints_attribute("strides", (stride, stride)),
            )
        )  # fmt: skip
        weights = [GAIN, -GAIN / 2, -GAIN / 2] + [0.0] * (3 * (planes - 1))
        tensors.append(_tensor(f"w{stride}", (planes, 3, 1, 1), weights))
        tensors.append(_tensor(f"b{stride}", (planes,), [BIAS] + [REACH.get(stride, 1.0)] * (planes - 1)))
        nodes.append(
            _node(
                "Conv", [f"pool{stride}", f"w{stride}", f"b{stride}"], f"head{stride}",
                _ints_attribute("kernel_shape", (1, 1)), _int_attribute("group", 1),
            )
        )  # fmt: skip
        outputs.append(_value(f"head{stride}", (1, planes, HEIGHT // stride, WIDTH // stride)))
    graph = b"".join(
        [
            *(_bytes(1, node) for node in nodes),
            _bytes(2, "red_square"),
            *(_bytes(5, tensor) for tensor in tensors),
            _bytes(11, _value("images", (1, 3, HEIGHT, WIDTH))),
            *(_bytes(12, output) for output in outputs),
        ]
    )
    opset = _bytes(1, "") + _int(2, 12)
    return _int(1, 7) + _bytes(2, "target_nav tests") + _bytes(7, graph) + _bytes(8, opset)


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(red_square_network())
