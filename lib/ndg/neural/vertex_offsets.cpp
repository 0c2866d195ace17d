// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/vertex_offsets.h"

#include "ndg/deform/rest_offsets.h"

namespace ndg {
namespace {

constexpr double mm = 1e-3;

class VertexOffsets : public OutputSpace {
public:
    explicit VertexOffsets(const Template& body_template) : at_rest_(body_template) {}

    int width() const override { return 3 * at_rest_.num_vertices(); }
    OutputKind kind() const override { return OutputKind::vertex_vectors; }

    std::string script() const override { return "    return 0.001 * y.reshape(y.size(0), -1, 3)\n"; }

    void target(const PosedBody& posed, const RestOperators&, const Eigen::Ref<const PointsF>& vertices,
                float* target) const override
    {
        Eigen::Map<PointsF>(target, at_rest_.num_vertices(), 3) =
            (at_rest_.offsets(posed, vertices) / mm).cast<float>();
    }

    Points vertices(const PosedBody& posed, RestCache&, const float* prediction) const override
    {
        const Eigen::Map<const PointsF> offsets(prediction, at_rest_.num_vertices(), 3);
        return at_rest_.vertices(posed, mm * offsets.cast<double>());
    }

private:
    RestOffsets at_rest_;
};

}  // namespace

std::unique_ptr<OutputSpace> make_vertex_offsets(const Template& body_template, const NetworkOptions&)
{
    return std::make_unique<VertexOffsets>(body_template);
}

}  // namespace ndg
