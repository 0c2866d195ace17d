// SPDX-License-Identifier: Apache-2.0
// Which body in which poses: what every file of samples begins with, written and read here alone.
//   /GROUP/pairs    n x 2 int32, body and (first) pose
//   /GROUP/frames   n int32, poses of each sample; absent where every sample has one
//   /GROUP/splits   n strings
//   attributes method and bone_wrap
#pragma once

#include "ndg/body/posing.h"
#include "ndg/core/types.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ndg {

class H5Reader;
class H5Writer;

/// Names of the splits, in storage order.
inline const std::vector<std::string> split_names = {"train", "validation", "test"};
/// Throws InputError naming `path`, dataset `name` and place of the first that is not among split_names.
void check_split_names(const std::string& path, const std::string& name, const std::vector<std::string>& splits);

/// A body of the body file in a sequence of poses: `num_frames` successive ones of the pose file, from `pose_idx` on.
/// A quasi-static sample is a sequence of length one.
struct SamplePair {
    int body_idx = 0;
    int pose_idx = 0;
    int num_frames = 1;
};
bool operator==(const SamplePair& a, const SamplePair& b);
/// By body, then pose.
bool operator<(const SamplePair& a, const SamplePair& b);
/// "body 3 in pose 7" or "body 3 in poses 7 to 9".
std::string describe(const SamplePair& pair);
/// For what knows single poses only: throws InputError when the pair names a body or pose that is not there, or is a
/// sequence of several poses.
void require_pair(const SamplePair& pair, std::size_t num_bodies, std::size_t num_poses);

/// A body, its poses and their split: what tells samples apart.
struct SampleKey {
    std::string split;
    SamplePair pair;
};
bool operator<(const SampleKey& a, const SampleKey& b);
/// "body 3 in pose 7 of split test".
std::string describe(const SampleKey& key);

struct SampleIndex {
    std::string method;    ///< "FEM", "NDG", "Gradient Skinning", "LBS"
    PosingOptions posing;  ///< how the bodies were posed
    std::vector<SamplePair> pairs;
    std::vector<std::string> pair_splits;  ///< split name of each sample

    int size() const { return static_cast<int>(pairs.size()); }
    SampleKey key(int sample_idx) const { return {pair_splits[sample_idx], pairs[sample_idx]}; }
    /// A payload has one slice a frame, sample after sample: their number, and the sample's first.
    std::size_t num_slices() const;
    std::size_t first_slice(int sample_idx) const;
};

/// /GROUP/pairs and, where there are sequences, /GROUP/frames. `description` of the pairs.
void write_pairs(H5Writer& writer, const std::string& group, const std::vector<SamplePair>& pairs,
                 const std::string& description = "body and pose of each sample");
std::vector<SamplePair> read_pairs(const H5Reader& reader, const std::string& group);

/// Throws Error where there is not one split a pair, InputError where it is not the name of one.
void write_sample_index(H5Writer& writer, const std::string& path, const std::string& group, const SampleIndex& index);
SampleIndex read_sample_index(const H5Reader& reader, const std::string& group);

}  // namespace ndg
