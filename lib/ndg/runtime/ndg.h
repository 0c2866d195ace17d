// SPDX-License-Identifier: Apache-2.0
/* libndg: bodies posed by a trained network, frame by frame, for programs in C and in whatever can call C.
 *
 * Metres, y up, the body faces +z, its left side is +x. No function throws or exits: those that can fail return a
 * code, and ndg_error() then has one sentence. One ndg_runtime may be used by one thread at a time; several may be used
 * side by side. All pointers that are handed out belong to the ndg_runtime, stay the same while it lives, and hold the
 * last frame. docs/runtime.md has a program in C and one in Python. */
#ifndef NDG_H
#define NDG_H

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define NDG_API __attribute__((visibility("default")))
#else
#define NDG_API
#endif

typedef struct ndg_runtime ndg_runtime;

/* What functions return that can fail. */
enum {
    NDG_DONE = 0,
    NDG_FAILED = 1,   /* while running */
    NDG_BAD_INPUT = 2 /* files, indices or values that do not fit */
};

/* Surfaces of a body. */
typedef enum {
    NDG_SKIN = 0,        /* all of it, with head, hands and toes */
    NDG_MUSCLE_WRAP = 1, /* between muscle and fat */
    NDG_BONE_WRAP = 2,   /* between bone and muscle */
    NDG_ANATOMY = 3      /* all bones and muscles, one part after the other */
} ndg_surface;

/* One bone or muscle: ranges of the vertices and triangles of NDG_ANATOMY, ends excluded. */
typedef struct {
    const char* name;
    int is_bone;
    int vertex_begin, vertex_end;
    int triangle_begin, triangle_end;
} ndg_part;

/* One sentence about the last call in this thread that failed; "" if none did. */
NDG_API const char* ndg_error(void);

/* Threads of all that follows in this process; 0: one a core. */
NDG_API void ndg_set_num_threads(int count);

/* Reads a template and its bodies (files of make-template and build-layers) and maps a model (of export-runtime). */
NDG_API int ndg_load(const char* template_path, const char* bodies_path, const char* model_path, ndg_runtime** runtime);
/* NULL does nothing. */
NDG_API void ndg_free(ndg_runtime* runtime);

/* Names are NULL for an index that does not exist. */
NDG_API int ndg_num_bodies(const ndg_runtime* runtime);
NDG_API const char* ndg_body_name(const ndg_runtime* runtime, int body);
NDG_API int ndg_num_joints(const ndg_runtime* runtime);
NDG_API const char* ndg_joint_name(const ndg_runtime* runtime, int joint);
NDG_API int ndg_joint_parent(const ndg_runtime* runtime, int joint); /* -1: the root, or no such joint */

/* Chooses a body; costs some tenths of a second. */
NDG_API int ndg_set_body(ndg_runtime* runtime, int body);

/* One frame. `parent_from_joint`: for each joint the rotation from its frame to its parent's (of the root: to the
 * world) as a quaternion x, y, z, w, all joints one after the other; at rest all are 0, 0, 0, 1, for at rest every
 * joint's frame is that of the world. They need not be of length one. `root_displacement`: x, y, z of where the root
 * joint goes from its place at rest. */
NDG_API int ndg_set_pose(ndg_runtime* runtime, const double* parent_from_joint, const double* root_displacement);

/* Vertices of the last frame, x, y, z one after the other. 0 and NULL for a surface that does not exist. */
NDG_API int ndg_num_vertices(const ndg_runtime* runtime, ndg_surface surface);
NDG_API const float* ndg_vertices(const ndg_runtime* runtime, ndg_surface surface);
/* Three vertices of the surface each, counter-clockwise seen from outside; the same for all bodies and frames. */
NDG_API int ndg_num_triangles(const ndg_runtime* runtime, ndg_surface surface);
NDG_API const int* ndg_triangles(const ndg_runtime* runtime, ndg_surface surface);

NDG_API int ndg_num_parts(const ndg_runtime* runtime);
NDG_API int ndg_get_part(const ndg_runtime* runtime, int index, ndg_part* part);

#ifdef __cplusplus
}
#endif

#endif
