# SPDX-License-Identifier: Apache-2.0
"""Networks as export-release writes them, read and computed with numpy alone."""
import json
import math
import struct

import numpy

DTYPES = {"F32": "<f4", "F64": "<f8", "I32": "<i4"}
erf = numpy.vectorize(math.erf, otypes=[float])


def read_safetensors(path):
    """Tensors by name, and the metadata."""
    with open(path, "rb") as file:
        data = file.read()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8:8 + length])
    metadata = header.pop("__metadata__")
    tensors, covered = {}, []
    for name, entry in header.items():
        begin, end = entry["data_offsets"]
        tensors[name] = numpy.frombuffer(data[8 + length + begin:8 + length + end], DTYPES[entry["dtype"]]).reshape(entry["shape"])
        covered.append((begin, end))
    covered.sort()
    assert covered[0][0] == 0 and all(a[1] == b[0] for a, b in zip(covered, covered[1:])), "holes between tensors"
    assert covered[-1][1] == len(data) - 8 - length, "the file has another length than its header says"
    return tensors, metadata


def fields(data):
    """Fields of a protocol buffer: number and value."""
    at, result = 0, []

    def varint():
        nonlocal at
        value, shift = 0, 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value - (1 << 64) if value >= 1 << 63 else value

    while at < len(data):
        tag = varint()
        number, kind = tag >> 3, tag & 7
        if kind == 0:
            result.append((number, varint()))
        elif kind == 2:
            size = varint()
            result.append((number, data[at:at + size]))
            at += size
        elif kind == 5:
            result.append((number, struct.unpack("<f", data[at:at + 4])[0]))
            at += 4
        else:
            raise ValueError(f"wire type {kind}")
    assert at == len(data), "a field reaches past its message"
    return result


class Onnx:
    """A graph of the operators that export-release uses, by their definitions in onnx/docs/Operators.md."""

    def __init__(self, path):
        with open(path, "rb") as file:
            model = fields(memoryview(file.read()))
        self.opset = dict(fields(dict(model)[8]))[2]
        self.metadata = {bytes(p[1]).decode(): bytes(p[2]).decode() for p in (dict(fields(v)) for n, v in model if n == 14)}
        graph = fields(dict(model)[7])
        self.inputs, self.outputs = ([bytes(dict(fields(v))[1]).decode() for n, v in graph if n == number] for number in (11, 12))
        self.constants, self.nodes = {}, []
        for number, value in graph:
            if number == 5:
                tensor = fields(value)
                kind, name, raw = (dict(tensor)[i] for i in (2, 8, 9))
                shape = [v for n, v in tensor if n == 1]
                self.constants[bytes(name).decode()] = numpy.frombuffer(raw, {1: "<f4", 7: "<i8"}[kind]).reshape(shape)
            elif number == 1:
                node = fields(value)
                names = [[bytes(v).decode() for n, v in node if n == i] for i in (1, 2, 4)]
                attributes = {}
                for n, v in node:
                    if n == 5:
                        attribute = dict(fields(v))
                        attributes[bytes(attribute[1]).decode()] = attribute[2 if attribute[20] == 1 else 3]
                self.nodes.append((names[2][0], names[0], names[1][0], attributes))

    def run(self, **inputs):
        assert sorted(inputs) == sorted(self.inputs), (sorted(inputs), sorted(self.inputs))
        values = {**self.constants, **{k: numpy.asarray(v, numpy.float32) for k, v in inputs.items()}}
        for op, names, output, attributes in self.nodes:
            values[output] = getattr(self, op)(*(values[name] for name in names), **attributes)
            assert values[output].dtype == numpy.float32, (op, values[output].dtype)
        return {name: values[name] for name in self.outputs}

    Sub, Mul, Div, Add, MatMul = numpy.subtract, numpy.multiply, numpy.divide, numpy.add, numpy.matmul

    @staticmethod
    def Identity(x):
        return x

    @staticmethod
    def Reshape(x, shape):
        return x.reshape([x.shape[i] if extent == 0 else extent for i, extent in enumerate(shape)])

    @staticmethod
    def Concat(*parts, axis):
        return numpy.concatenate(parts, axis)

    @staticmethod
    def Gather(x, indices, axis):
        return numpy.take(x, indices, axis)

    @staticmethod
    def Slice(x, starts, ends, axes):
        assert list(axes) == [1]
        return x[:, starts[0]:ends[0]]

    @staticmethod
    def Gemm(a, b, c, transB):
        return a @ b.T + c if transB else a @ b + c

    @staticmethod
    def Erf(x):
        return erf(x).astype(numpy.float32)

    @staticmethod
    def LayerNormalization(x, scale, bias, axis, epsilon):
        assert axis == -1
        mean = x.mean(-1, keepdims=True)
        deviation = numpy.sqrt(((x - mean) ** 2).mean(-1, keepdims=True) + numpy.float32(epsilon))
        return (x - mean) / deviation * scale + bias


def raw_outputs(tensors, config, rotations, codes):
    """What the network gives for poses (B x J x 3 x 3) and codes (B x d, m), in double, of safetensors and config.json."""
    turned = (rotations - numpy.eye(3)) * tensors["input.visible_joints"][None, :, None, None]
    features = turned.reshape(len(turned), -1)
    if config["sees_shape"]:
        features = numpy.concatenate([features, codes / config["code_scale"]], 1)
    results, columns = [], []
    for part in config["parts"]:
        x = features if part["inputs"] is None else features[:, tensors[part["inputs"]]]
        for layer in part["layers"]:
            weight, bias = (tensors[f"{layer['tensors']}.{name}"].astype(float) for name in ("weight", "bias"))
            x = x @ weight.T + bias
            if layer["layer_norm"]:
                scale, offset = (tensors[f"{layer['tensors']}.{name}"].astype(float) for name in ("norm_weight", "norm_bias"))
                x = (x - x.mean(1, keepdims=True)) / numpy.sqrt(x.var(1, keepdims=True) + config["layer_norm_epsilon"])
                x = x * scale + offset
            if layer["activation"] == "gelu":
                x = 0.5 * x * (1 + erf(x / math.sqrt(2)))
        if part["output_basis"] is not None:
            x = x @ tensors[part["output_basis"]].astype(float)
        results.append(x)
        columns.append(tensors[part["outputs"]] if part["outputs"] is not None else numpy.arange(x.shape[1]))
    outputs = numpy.empty((len(turned), sum(len(c) for c in columns)))
    for x, c in zip(results, columns):
        outputs[:, c] = x
    return outputs


def exponential(matrices):
    """By the series, in double: matrices of norm below 8 or so."""
    scaled, power = matrices / 2.0 ** 8, numpy.broadcast_to(numpy.eye(3), matrices.shape).copy()
    term = power.copy()
    for k in range(1, 16):
        term = term @ scaled / k
        power = power + term
    for _ in range(8):
        power = power @ power
    return power
