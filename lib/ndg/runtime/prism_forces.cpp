// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/prism_forces.h"

#include "ndg/core/error.h"
#include "ndg/geometry/matrix_lanes.h"
#include "ndg/runtime/runtime_model.h"

#include <cmath>

namespace ndg {
namespace {

using Block = matrix_lanes::Block<float>;
static_assert(Block::lanes == group_prisms);

/// So many ranges of groups have sums of their own, whoever works on them.
constexpr int num_pieces = 4;

}  // namespace

struct PrismForces::Kernels {
    /// R_p: the blend of the joints' quaternions, with signs as that of the heaviest, as blend_rotations.
    static void blend(const Influence* begin, const Influence* end, const Quaternions& joints, Block& rotations)
    {
        alignas(64) float reference[4][lanes], sum[4][lanes];
        for (int c = 0; c < 4; ++c)
            for (int l = 0; l < lanes; ++l) {
                reference[c][l] = joints[c][begin->joints[l]];
                sum[c][l] = begin->weights[l] * reference[c][l];
            }
        for (const Influence* influence = begin + 1; influence != end; ++influence) {
            alignas(64) float q[4][lanes], weight[lanes];
            for (int c = 0; c < 4; ++c)
                for (int l = 0; l < lanes; ++l) q[c][l] = joints[c][influence->joints[l]];
            for (int l = 0; l < lanes; ++l) {
                const float cosine = q[0][l] * reference[0][l] + q[1][l] * reference[1][l] + q[2][l] * reference[2][l] +
                                     q[3][l] * reference[3][l];
                weight[l] = cosine < 0.0F ? -influence->weights[l] : influence->weights[l];
            }
            for (int c = 0; c < 4; ++c)
                for (int l = 0; l < lanes; ++l) sum[c][l] += weight[l] * q[c][l];
        }
        for (int l = 0; l < lanes; ++l) {
            const float x = sum[0][l], y = sum[1][l], z = sum[2][l], w = sum[3][l];
            const float twice = 2.0F / (x * x + y * y + z * z + w * w);
            rotations.m[0][l] = 1.0F - twice * (y * y + z * z);
            rotations.m[1][l] = twice * (x * y - w * z);
            rotations.m[2][l] = twice * (x * z + w * y);
            rotations.m[3][l] = twice * (x * y + w * z);
            rotations.m[4][l] = 1.0F - twice * (x * x + z * z);
            rotations.m[5][l] = twice * (y * z - w * x);
            rotations.m[6][l] = twice * (x * z - w * y);
            rotations.m[7][l] = twice * (y * z + w * x);
            rotations.m[8][l] = 1.0F - twice * (x * x + y * y);
        }
    }

    /// Adds the forces of a range of groups to `sums`.
    static void add_forces(const PrismForces& self, const float* outputs, int begin, int end, float* sums)
    {
        for (int g = begin; g < end; ++g) {
            const Group& group = self.groups_[g];
            Block q, residuals, rotations, gradients;
            for (int e = 0; e < 9; ++e)
                for (int l = 0; l < lanes; ++l) q.m[e][l] = outputs[(9 * g + e) * lanes + l];
            if (self.is_exponential_) {
                matrix_lanes::exponential(q, residuals);
            } else {
                for (int e = 0; e < 9; ++e)
                    for (int l = 0; l < lanes; ++l) residuals.m[e][l] = q.m[e][l] + (e % 4 == 0 ? 1.0F : 0.0F);
            }
            blend(self.influences_.data() + group.influence_begin, self.influences_.data() + group.influence_end,
                  self.quaternions_, rotations);
            matrix_lanes::multiply<false, false>(rotations, residuals, gradients);
            for (int a = 0; a < 6; ++a) {
                alignas(64) float force[3][lanes];
                for (int c = 0; c < 3; ++c)
                    for (int l = 0; l < lanes; ++l)
                        force[c][l] = group.operators[3 * a][l] * gradients.m[3 * c][l] +
                                      group.operators[3 * a + 1][l] * gradients.m[3 * c + 1][l] +
                                      group.operators[3 * a + 2][l] * gradients.m[3 * c + 2][l];
                for (int l = 0; l < lanes; ++l) {
                    float* const sum = sums + 4 * static_cast<std::ptrdiff_t>(group.vertices[a][l]);
                    for (int c = 0; c < 3; ++c) sum[c] += force[c][l];
                }
            }
        }
    }
    NDG_WIDE_REGISTERS static void add_forces_wide(const PrismForces& self, const float* outputs, int begin, int end,
                                                   float* sums)
    {
        add_forces(self, outputs, begin, end, sums);
    }
};

PrismForces::PrismForces(const Template& body_template, const std::vector<int>& prisms, const ModelTraits& traits)
    : num_wrap_(body_template.num_wrap_vertices()),
      num_free_(body_template.num_volume_vertices() - body_template.num_wrap_vertices()),
      is_exponential_(traits.parametrisation == ParametrisationKind::exponential),
      is_wide_(matrix_lanes::has_wide_registers()),
      prisms_(prisms),
      groups_(prisms.size() / lanes),
      sums_(num_pieces, PointColumns::Zero(4, num_free_ + 1))
{
    const SkinningWeights weights = body_template.prism_weights();
    for (std::vector<float>& component : quaternions_) component.resize(body_template.skeleton.joint_names.size());
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        Group& group = groups_[g];
        group.influence_begin = static_cast<int>(influences_.size());
        for (int slot = 0; slot < max_influences; ++slot) {
            Influence influence = {};
            bool any = slot == 0;
            for (int l = 0; l < lanes; ++l) {
                const int prism = prisms_[lanes * g + l];
                if (!traits.rotation || prism < 0) {  // the root's rotation
                    influence.weights[l] = slot == 0 ? 1.0F : 0.0F;
                    continue;
                }
                // The heaviest comes first, the first of equals.
                Eigen::Index heaviest = 0;
                weights.weights.row(prism).maxCoeff(&heaviest);
                const Eigen::Index from = slot == 0 ? heaviest : slot == heaviest ? 0 : slot;
                influence.joints[l] = weights.joints(prism, from);
                influence.weights[l] = static_cast<float>(weights.weights(prism, from));
                any = any || influence.weights[l] > 0.0F;
            }
            if (any) influences_.push_back(influence);
        }
        group.influence_end = static_cast<int>(influences_.size());
        for (int a = 0; a < 6; ++a)
            for (int l = 0; l < lanes; ++l) {
                const int prism = prisms_[lanes * g + l];
                const int vertex = prism < 0 ? -1 : body_template.prisms(prism, a) - num_wrap_;
                group.vertices[a][l] = vertex < 0 ? num_free_ : vertex;
            }
    }
}

void PrismForces::set_rest(const RestOperators& rest, const PoissonMatrices& matrices)
{
    for (std::size_t g = 0; g < groups_.size(); ++g)
        for (int l = 0; l < lanes; ++l) {
            const int prism = prisms_[lanes * g + l];
            for (int a = 0; a < 6; ++a)
                for (int k = 0; k < 3; ++k)
                    groups_[g].operators[3 * a + k][l] =
                        prism < 0 ? 0.0F : static_cast<float>(rest.volume(prism) * rest.gradient(prism)(k, a));
        }
    const Eigen::SparseMatrix<double, Eigen::RowMajor> coupling = matrices.coupling;
    coupling_begin_.assign(coupling.outerIndexPtr(), coupling.outerIndexPtr() + num_free_ + 1);
    coupling_column_.assign(coupling.innerIndexPtr(), coupling.innerIndexPtr() + coupling.nonZeros());
    coupling_.resize(static_cast<std::size_t>(coupling.nonZeros()));
    for (std::size_t i = 0; i < coupling_.size(); ++i) coupling_[i] = static_cast<float>(coupling.valuePtr()[i]);
}

void PrismForces::right_hand_side(const std::vector<float>& outputs,
                                  const std::vector<Eigen::Isometry3d>& world_from_rest, PointColumns& volume)
{
#pragma omp single
    for (std::size_t j = 0; j < world_from_rest.size(); ++j) {
        const Eigen::Quaterniond rotation = Eigen::Quaterniond(world_from_rest[j].linear()).normalized();
        for (int c = 0; c < 4; ++c) quaternions_[c][j] = static_cast<float>(rotation.coeffs()[c]);
    }
    const auto num_groups = static_cast<std::ptrdiff_t>(groups_.size());
    const auto add = is_wide_ ? Kernels::add_forces_wide : Kernels::add_forces;
#pragma omp for schedule(dynamic, 1)
    for (int piece = 0; piece < num_pieces; ++piece) {
        sums_[piece].setZero();
        add(*this, outputs.data(), static_cast<int>(num_groups * piece / num_pieces),
            static_cast<int>(num_groups * (piece + 1) / num_pieces), sums_[piece].data());
    }
#pragma omp for schedule(static)
    for (int v = 0; v < num_free_; ++v) {
        Eigen::Vector4f sum = sums_[0].col(v);
        for (int piece = 1; piece < num_pieces; ++piece) sum += sums_[piece].col(v);
        for (int i = coupling_begin_[v]; i < coupling_begin_[v + 1]; ++i)
            sum -= coupling_[i] * volume.col(coupling_column_[i]);
        volume.col(num_wrap_ + v) = sum;
    }
}

void PrismForces::use_wide_registers(bool wide)
{
    is_wide_ = wide && matrix_lanes::has_wide_registers();
}

std::size_t PrismForces::table_bytes() const
{
    return sizeof(Group) * groups_.size() + sizeof(Influence) * influences_.size() +
           (sizeof(int) + sizeof(float)) * coupling_.size();
}

}  // namespace ndg
