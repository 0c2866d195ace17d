// SPDX-License-Identifier: Apache-2.0
// Deformed volumes on disk, FEM samples and predictions alike: format "ndg-deformations", version 1 (docs/formats.md).
#pragma once

#include "ndg/dataset/sample_file.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace ndg {

struct VirtualSource;

/// A sample that has no deformation, and why.
struct FailedSample {
    SamplePair pair;
    std::string split, reason;
};

/// What stands in such a file. The vertices are in memory (small sets) or are read when asked for (an opened set).
struct DeformationSet : SampleIndex {
    int num_volume_vertices = 0;
    std::vector<std::vector<float>> vertices;  ///< per sample N_v * 3, row-major; none in an opened set
    /// Per-sample figures, e.g. energy_joule, residual_newton, residual_relative, iterations, converged,
    /// inverted_prisms, corner_inverted_prisms, seconds...: name -> one value a sample.
    std::map<std::string, std::vector<double>> statistics;
    std::vector<std::string> stop_reasons;  ///< why the solver stopped, one a sample; empty where there is no solver
    std::vector<FailedSample> failures;
    std::map<std::string, std::string> attributes;  ///< text of the file's root beyond what every file has
    std::shared_ptr<const SampleReader> file;       ///< of an opened set

    /// "" where there is none of that name.
    std::string attribute(const std::string& name) const;
    /// Frames x N_v x 3, row-major. Of an opened set: throws InputError where the file is damaged; may be called by any
    /// thread.
    std::vector<float> coordinates(int sample_idx) const;
    /// N_v x 3, of a sample of one frame (InputError otherwise).
    Points points(int sample_idx) const;
    void add(const SamplePair& pair, const std::string& split, const Points& vertices);
};

/// Writes the lists of a set at once and the vertices sample after sample; without commit() nothing is left behind.
class DeformationWriter : public SampleWriter {
public:
    /// `head`: everything but the vertices.
    DeformationWriter(const std::string& path, const DeformationSet& head, const Provenance& provenance);
};
/// A set with its vertices.
void write_deformations(const std::string& path, const DeformationSet& set, const Provenance& provenance);
/// The lists of `head` with the vertices left in the files they stand in (a virtual dataset over `sources`).
void link_deformations(const std::string& path, const DeformationSet& head, const Provenance& provenance,
                       const std::vector<VirtualSource>& sources);
/// Paths of the files the vertices lie in, relative to the file's folder; none where they lie in the file itself.
std::vector<std::string> deformation_sources(const std::string& path);

/// Everything but the vertices, which are read when asked for: a set of any size. num_volume_vertices -1: unchecked.
/// Throws InputError where a file that the samples lie in is missing.
DeformationSet open_deformations(const std::string& path, int num_volume_vertices = -1);

}  // namespace ndg
