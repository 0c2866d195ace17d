// SPDX-License-Identifier: Apache-2.0
// A body model in the form of SMPL's, of made-up bones, and AMASS files of it with what forward kinematics gives.
#pragma once

#include "ndg/core/file.h"
#include "support/support.h"

#include <iostream>
#include <string>

namespace ndg::test {

/// Forward kinematics is that of SMPL: Rodrigues' rotations along the chain, joints that depend on shape, "trans" on
/// top.
constexpr const char* smpl_model_script = R"(import numpy as np
rng = np.random.default_rng(7)
parents = [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19]
# Limbs aslant: thighs inwards, shins backwards, arms down and back, as people are.
offsets = np.array([[0, -0.2, 0.03], [0.06, -0.09, -0.01], [-0.06, -0.09, -0.01], [0, 0.11, -0.03], [0.045, -0.38, -0.005],
    [-0.045, -0.38, -0.005], [0, 0.135, 0.005], [-0.015, -0.4, -0.04], [0.015, -0.4, -0.04], [0, 0.05, 0.03],
    [0.04, -0.06, 0.12], [-0.04, -0.06, 0.12], [0, 0.21, -0.03], [0.08, 0.11, -0.015], [-0.08, 0.11, -0.015],
    [0.005, 0.09, 0.05], [0.09, 0.03, -0.01], [-0.09, 0.03, -0.01], [0.26, -0.025, -0.03], [-0.26, -0.025, -0.03],
    [0.25, 0.012, -0.005], [-0.25, 0.012, -0.005]])
for side, wrist in ((1, 20), (-1, 21)):
    for finger, start in enumerate(([.1, -.01, .02], [.11, 0, 0], [.08, -.01, -.04], [.09, -.005, -.025], [.04, -.02, .03])):
        first = len(parents)
        for k in range(3):
            parents.append(wrist if k == 0 else first + k - 1)
            step = start if k == 0 else [.03, -.004, .02 if finger == 4 else -.002 * finger]
            offsets = np.vstack([offsets, [side * step[0], step[1], step[2]]])
mean = np.zeros((52, 3))
for j, parent in enumerate(parents):
    mean[j] = offsets[j] + (mean[parent] if parent >= 0 else 0)
# Vertices: two about every joint; shape 0 lengthens all, shape 1 lowers the hands, shape 2 is noise of a centimetre.
vertices = np.concatenate([mean + [0.03, 0, 0], mean - [0.03, 0, 0]])
regressor = np.hstack([np.eye(52), np.eye(52)]) / 2
shapes = np.zeros((104, 3, 3))
shapes[:, :, 0] = 0.05 * vertices
shapes[:, 1, 1] = -0.1 * np.abs(vertices[:, 0])
shapes[:, :, 2] = 0.01 * np.tile(rng.standard_normal((52, 3)), (2, 1))
np.savez('model.npz', J_regressor=regressor, v_template=np.asfortranarray(vertices), shapedirs=shapes.astype('f4'))
np.savez('joints.npz', J=mean)
np.savez('mirrored.npz', J=mean * [-1, 1, 1])
np.savez('inches.npz', J=mean * 39.37)
np.savez('few.npz', J=mean[:22])
np.savez('flat.npz', J=mean[:, :2])
np.savez('other.npz', J_regressor=regressor[:, 1:], v_template=vertices)
np.savez('nothing.npz', betas=np.zeros(3))

def rotation(r):
    angle = np.linalg.norm(r)
    k = r / angle if angle else r
    K = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K

def kinematics(joints, pose, trans):
    turns, at = [], []
    for j, parent in enumerate(parents):
        local = rotation(pose[3 * j:3 * j + 3])
        turns.append(local if parent < 0 else turns[parent] @ local)
        at.append(joints[0] + trans if parent < 0 else at[parent] + turns[parent] @ (joints[j] - joints[parent]))
    return np.array(at)

frames = 6
poses = 0.35 * rng.standard_normal((frames, 156))
poses[0] = 0
poses[:, :3] = [np.pi / 2, 0, 0]
poses[0, 48:54] = [0, 0, -1.2, 0, 0, 1.2]
trans = rng.standard_normal((frames, 3))
for name, betas in (('plain', np.zeros(3)), ('shaped', np.array([0.8, 1.5, -1.0]))):
    joints = regressor @ (vertices + shapes.astype('f4') @ betas)
    truth = np.array([kinematics(joints, poses[f], trans[f]) for f in range(frames)])
    np.savez(name + '_poses.npz', poses=poses, trans=trans, mocap_framerate=30., betas=np.append(betas, [3.0]))
    np.savetxt(name + '.txt', np.stack([truth[..., 0], truth[..., 2], -truth[..., 1]], -1).reshape(frames, -1))
)";

/// Fills the folder; false where there is no Python with numpy.
inline bool write_smpl_model(const TemporaryFolder& folder)
{
    write_file(folder.file("write.py"), smpl_model_script);
    for (const std::string python : {"/usr/bin/python3", "python3"}) {
        if (run_command(python + " -c 'import numpy'").exit_code != 0) continue;
        if (run_command("cd " + folder.path() + " && " + python + " write.py").exit_code == 0) return true;
    }
    std::cout << "Skipped: no python3 with numpy (Debian: python3-numpy)" << std::endl;
    return false;
}

}  // namespace ndg::test
