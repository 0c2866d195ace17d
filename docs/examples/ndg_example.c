// SPDX-License-Identifier: Apache-2.0
/* Bends the left elbow of the first body and writes its skin as an OBJ file.
 * ndg_example template.h5 bodies.h5 model.ndg elbow.obj */
#include "ndg/runtime/ndg.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int fail(void)
{
    fprintf(stderr, "ndg_example: %s\n", ndg_error());
    return 1;
}

/* Turns joint `name` by an angle about the z axis of its frame. */
static void turn(const ndg_runtime *runtime, const char *name, double angle, double *quaternions)
{
    int joint;
    for (joint = 0; joint < ndg_num_joints(runtime); ++joint) {
        if (strcmp(ndg_joint_name(runtime, joint), name) != 0) continue;
        quaternions[4 * joint + 2] = sin(0.5 * angle);
        quaternions[4 * joint + 3] = cos(0.5 * angle);
    }
}

int main(int argc, char **argv)
{
    const int num_frames = 60;
    const double on_the_spot[3] = {0, 0, 0}, bent = 2.0; /* radians */
    ndg_runtime *runtime = NULL;
    double *pose;
    FILE *file;
    int i, frame;
    if (argc != 5) {
        fprintf(stderr, "ndg_example template.h5 bodies.h5 model.ndg elbow.obj\n");
        return 2;
    }
    if (ndg_load(argv[1], argv[2], argv[3], &runtime) != NDG_DONE) return fail();
    if (ndg_set_body(runtime, 0) != NDG_DONE) return fail();

    pose = calloc(4 * (size_t)ndg_num_joints(runtime), sizeof(double));
    for (i = 0; i < ndg_num_joints(runtime); ++i) pose[4 * i + 3] = 1; /* at rest */
    for (frame = 1; frame <= num_frames; ++frame) {
        turn(runtime, "left_forearm", bent * frame / num_frames, pose);
        if (ndg_set_pose(runtime, pose, on_the_spot) != NDG_DONE) return fail();
        /* here a program would show ndg_vertices(runtime, NDG_SKIN), or a bone of NDG_ANATOMY (ndg_get_part) */
    }

    file = fopen(argv[4], "w");
    if (file == NULL) {
        perror(argv[4]);
        return 1;
    }
    for (i = 0; i < ndg_num_vertices(runtime, NDG_SKIN); ++i) {
        const float *v = ndg_vertices(runtime, NDG_SKIN) + 3 * i;
        fprintf(file, "v %.6f %.6f %.6f\n", v[0], v[1], v[2]);
    }
    for (i = 0; i < ndg_num_triangles(runtime, NDG_SKIN); ++i) {
        const int *t = ndg_triangles(runtime, NDG_SKIN) + 3 * i;
        fprintf(file, "f %d %d %d\n", t[0] + 1, t[1] + 1, t[2] + 1);
    }
    if (fclose(file) != 0) {
        perror(argv[4]);
        return 1;
    }
    printf("%s: %s, %d vertices\n", argv[4], ndg_body_name(runtime, 0), ndg_num_vertices(runtime, NDG_SKIN));
    free(pose);
    ndg_free(runtime);
    return 0;
}
