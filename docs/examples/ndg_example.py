# SPDX-License-Identifier: Apache-2.0
"""libndg from Python with ctypes and numpy.

ndg_example.py libndg.so template.h5 bodies.h5 model.ndg: poses the first body and tells where its skin and femur are.
"""
import ctypes
import sys

import numpy

SKIN, MUSCLE_WRAP, BONE_WRAP, ANATOMY = range(4)


class Part(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("is_bone", ctypes.c_int),
                ("vertex_begin", ctypes.c_int), ("vertex_end", ctypes.c_int),
                ("triangle_begin", ctypes.c_int), ("triangle_end", ctypes.c_int)]


class Runtime:
    def __init__(self, library, template, bodies, model):
        self._library = ctypes.CDLL(library)
        for name in ("ndg_error", "ndg_body_name", "ndg_joint_name"):
            getattr(self._library, name).restype = ctypes.c_char_p
        self._library.ndg_vertices.restype = ctypes.POINTER(ctypes.c_float)
        self._library.ndg_triangles.restype = ctypes.POINTER(ctypes.c_int)
        self._handle = ctypes.c_void_p()
        self._check(self._library.ndg_load(template.encode(), bodies.encode(), model.encode(),
                                           ctypes.byref(self._handle)))
        joints = range(self._library.ndg_num_joints(self._handle))
        self.joints = [self._library.ndg_joint_name(self._handle, joint).decode() for joint in joints]
        self.parts = {}
        for index in range(self._library.ndg_num_parts(self._handle)):
            part = Part()
            self._check(self._library.ndg_get_part(self._handle, index, ctypes.byref(part)))
            self.parts[part.name.decode()] = slice(part.vertex_begin, part.vertex_end)

    def __del__(self):
        self._library.ndg_free(self._handle)

    def _check(self, code):
        if code != 0:
            raise RuntimeError(self._library.ndg_error().decode())

    def set_body(self, body):
        self._check(self._library.ndg_set_body(self._handle, body))

    def set_pose(self, quaternions, displacement=(0, 0, 0)):
        """Quaternions x, y, z, w of all joints, joints x 4."""
        rotations = numpy.ascontiguousarray(quaternions, dtype=numpy.float64)
        root = numpy.ascontiguousarray(displacement, dtype=numpy.float64)
        if rotations.shape != (len(self.joints), 4) or root.shape != (3,):
            raise ValueError(f"{len(self.joints)} quaternions and 3 coordinates, please")
        pointer = ctypes.POINTER(ctypes.c_double)
        self._check(self._library.ndg_set_pose(self._handle, rotations.ctypes.data_as(pointer),
                                               root.ctypes.data_as(pointer)))

    def vertices(self, surface):
        """N x 3, of the last frame; a view that the next frame overwrites."""
        count = self._library.ndg_num_vertices(self._handle, surface)
        return numpy.ctypeslib.as_array(self._library.ndg_vertices(self._handle, surface), (count, 3))

    def triangles(self, surface):
        count = self._library.ndg_num_triangles(self._handle, surface)
        return numpy.ctypeslib.as_array(self._library.ndg_triangles(self._handle, surface), (count, 3))


if __name__ == "__main__":
    runtime = Runtime(*sys.argv[1:5])
    runtime.set_body(0)
    pose = numpy.tile([0.0, 0.0, 0.0, 1.0], (len(runtime.joints), 1))
    pose[runtime.joints.index("left_thigh")] = [-numpy.sin(0.5), 0, 0, numpy.cos(0.5)]  # one radian forwards
    runtime.set_pose(pose)
    print("skin", runtime.vertices(SKIN).min(axis=0), runtime.vertices(SKIN).max(axis=0))
    for name, rows in runtime.parts.items():
        if "femur" in name.lower():
            print(name, runtime.vertices(ANATOMY)[rows].mean(axis=0))
