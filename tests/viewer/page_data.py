# SPDX-License-Identifier: Apache-2.0
"""What stands in a page, read without the viewer: numbers to hold against what the viewer makes of them."""
import base64
import json
import re
import zlib

import numpy


class PageData:
    def __init__(self, path):
        with open(path) as file:
            text = file.read()
        self.head = json.loads(re.search(r"NdgViewer\.open\((.*)\)</script>", text)[1])
        self.tables, self.frames = {}, {}
        for line in re.findall(r'NdgViewer\.add\((\{name:"[^\n]*\})\)</script>', text):
            name = re.search(r'name:"(\w+)"', line)[1]
            number = {k: int(v) for k, v in re.findall(r"(frame|count|row|stride|floats):(\d+)", line)}
            planes = numpy.frombuffer(zlib.decompress(base64.b64decode(re.search(r'data:"([^"]*)"', line)[1])), numpy.uint8)
            if "floats" in number:
                values = numpy.ascontiguousarray(planes.reshape(4, -1).T).view(numpy.float32).ravel()
            else:
                low, high = planes.reshape(2, -1).astype(numpy.int64)
                row = number.get("row", number["count"])
                table = (low + 256 * high).reshape(-1, row // number["stride"], number["stride"])
                table[0] = numpy.cumsum(table[0], axis=0)
                values = (numpy.cumsum(table, axis=0) % 65536).ravel()
            if "frame" in number:
                for i, frame in enumerate(values.reshape(-1, number["row"])):
                    self.frames[name, number["frame"] + i] = frame
            else:
                self.tables[name] = values

    def positions(self, values, origin):
        return (2 * values.reshape(-1, 3) / 65535 - 1) * self.head["span"] + numpy.array(origin)

    def points(self, frame, method):
        values = numpy.concatenate([self.frames["common", frame], self.frames[f"method_{method}", frame]])
        return self.positions(values, self.head["origins"][frame])

    def rest(self):
        return self.positions(self.tables["rest"], self.head["rest_origin"])

    def anatomy(self, layer, frame, method):
        """Vertices of "bone" or "muscle"."""
        table = lambda name: self.tables[f"{layer}_{name}"]
        points = self.points(frame, method)
        weights = table("weights").reshape(-1, 6).astype(numpy.uint16).view(numpy.int16) / self.head["weight_unit"]
        total = weights.sum(axis=1, keepdims=True)
        carried = numpy.einsum("vk,vkd->vd", weights / numpy.where(total == 0, 1, total), points[table("carriers").reshape(-1, 6)])
        x, y, z, w, *shift = self.frames["motions", frame].astype(float).reshape(-1, 7).T
        rotation = numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]).transpose(2, 0, 1)
        motion, rest = table("motions"), self.positions(table("rest"), self.head["rest_origin"])
        moved = numpy.einsum("vij,vj->vi", rotation[motion], rest) + numpy.array(shift).T[motion]
        share = (table("shares") / 65535)[:, None]
        return (1 - share) * carried + share * moved

    def layer_volume(self, layer, points):
        return self.prism_volumes(layer, points).sum()

    def skin_volume_change(self, points):
        """Of all flesh that touches a vertex of the wraps, against rest."""
        sums = []
        for at in (points, self.rest()):
            volumes = self.prism_volumes(0, at) + self.prism_volumes(1, at)
            sums.append(numpy.bincount(self.tables["wrap_triangles"], numpy.repeat(volumes, 3)))
        return sums[0] / sums[1] - 1

    def prism_volumes(self, layer, points):
        """Of the muscle layer (0) or the fat layer (1), m^3, by Gauss points in each prism."""
        wrap, triangles = self.head["num_wrap"], self.tables["wrap_triangles"].reshape(-1, 3)
        begin = [0, self.head["num_common"], self.head["num_common"] + wrap]
        inner, outer = points[begin[layer] + triangles], points[begin[layer + 1] + triangles]
        volume = 0
        for xi in (0.5 - 0.5 / 3 ** 0.5, 0.5 + 0.5 / 3 ** 0.5):
            middle = xi * outer + (1 - xi) * inner
            across = outer - inner
            for a, b in ((1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3)):
                normal = numpy.cross(middle[:, 1] - middle[:, 0], middle[:, 2] - middle[:, 0])
                up = (1 - a - b) * across[:, 0] + a * across[:, 1] + b * across[:, 2]
                volume = volume + (normal * up).sum(axis=1) / 12
        return volume

    def skin_section_area(self, frame, method, axis, place):
        """Area, m^2, of the plane's cut through the skin, from where its triangles cross the plane."""
        points = self.points(frame, method)
        triangles = points[self.tables["skin_points"][self.tables["skin_triangles"].reshape(-1, 3)]]
        above = triangles[:, :, axis] > place
        area = 0
        for corners, side in zip(triangles[above.any(1) & ~above.all(1)], above[above.any(1) & ~above.all(1)]):
            ends = []
            for i in range(3):
                j = (i + 1) % 3
                if side[i] != side[j]:
                    t = (place - corners[i, axis]) / (corners[j, axis] - corners[i, axis])
                    ends.append((side[i], numpy.delete(corners[i] + t * (corners[j] - corners[i]), axis)))
            (_, p), (_, q) = sorted(ends, key=lambda end: end[0])
            area += (p[0] * q[1] - p[1] * q[0]) / 2
        return abs(area)
