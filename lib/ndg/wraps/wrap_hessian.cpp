// SPDX-License-Identifier: Apache-2.0
// The Hessian of WrapEnergy.
#include "ndg/wraps/wrap_energy.h"

#include <algorithm>

namespace ndg {
void WrapEnergy::prepare_pattern()
{
    // Bending couples everything that a prism or a sample couples.
    const auto count = static_cast<int>(skin_.vertices.rows());
    std::vector<std::vector<int>> below(count);
    Eigen::Index entries = 0;
    for (int v = 0; v < count; ++v) {
        auto& rows = below[v];
        for (Eigen::SparseMatrix<double>::InnerIterator it(bone_bending_, v); it; ++it)
            if (it.row() >= v) rows.push_back(static_cast<int>(it.row()));
        for (const auto& [t, k] : incident_[v])
            for (int j = 0; j < 3; ++j)
                if (skin_.triangles(t, j) >= v) rows.push_back(skin_.triangles(t, j));
        std::sort(rows.begin(), rows.end());
        rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
        entries += 36 * static_cast<Eigen::Index>(rows.size());
    }
    hessian_.resize(6 * count, 6 * count);
    hessian_.resizeNonZeros(entries);
    int* outer = hessian_.outerIndexPtr();
    int* inner = hessian_.innerIndexPtr();
    int position = 0;
    for (int v = 0; v < count; ++v)
        for (int c = 0; c < 6; ++c) {
            outer[6 * v + c] = position;
            for (const int u : below[v])
                for (int r = 0; r < 6; ++r) inner[position++] = 6 * u + r;
        }
    outer[6 * count] = position;
}

double* WrapEnergy::block(int u, int v, Eigen::Index& stride)
{
    const int* outer = hessian_.outerIndexPtr() + 6 * v;
    const int* begin = hessian_.innerIndexPtr() + outer[0];
    const int* end = hessian_.innerIndexPtr() + outer[1];
    stride = outer[1] - outer[0];
    return hessian_.valuePtr() + (std::lower_bound(begin, end, 6 * u) - hessian_.innerIndexPtr());
}

WrapEnergy::ElementHessian WrapEnergy::element_hessian(const WrapPair& wraps, Eigen::Index t) const
{
    const Corners b = corners(wraps.bone, t), m = corners(wraps.muscle, t), s = corners(skin_.vertices, t);
    PrismVertices fat, flesh;
    fat << s, m;
    flesh << m, b;
    ElementHessian fat_hessian = ElementHessian::Zero(), flesh_hessian = ElementHessian::Zero();
    prism_barrier(fat, bounds(t, 0), nullptr, &fat_hessian);
    prism_barrier(flesh, bounds(t, 1), nullptr, &flesh_hessian);
    // A prism has its outer corners first, an element the bone wrap's.
    ElementHessian result;
    result << flesh_hessian.bottomRightCorner<9, 9>(), flesh_hessian.bottomLeftCorner<9, 9>(),
        flesh_hessian.topRightCorner<9, 9>(), flesh_hessian.topLeftCorner<9, 9>();
    result.bottomRightCorner<9, 9>() += fat_hessian.bottomRightCorner<9, 9>();
    result *= options.quality;
    Eigen::Matrix<double, 9, 9> bone_fit = Eigen::Matrix<double, 9, 9>::Zero(), muscle_fit = bone_fit;
    fit(bone_, margins(t, 0), 2.0 * options.cover, triangle_weights_[t], b, nullptr, &bone_fit);
    fit(muscle_, margins(t, 1), options.cover, options.muscle_fit * triangle_weights_[t], m, nullptr, &muscle_fit);
    result.topLeftCorner<9, 9>() += bone_fit;
    result.bottomRightCorner<9, 9>() += muscle_fit;
    return result;
}

const Eigen::SparseMatrix<double>& WrapEnergy::hessian(const WrapPair& wraps, double ridge)
{
    const Eigen::Index num_triangles = skin_.triangles.rows();
    std::vector<ElementHessian> elements(num_triangles);
#pragma omp parallel for schedule(static) if (num_triangles > 2000)  // fewer are not worth waking threads for
    for (Eigen::Index t = 0; t < num_triangles; ++t) elements[t] = element_hessian(wraps, t);

    std::fill(hessian_.valuePtr(), hessian_.valuePtr() + hessian_.nonZeros(), 0.0);
    Eigen::Index stride = 0;
    for (Eigen::Index t = 0; t < num_triangles; ++t)
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                const int u = skin_.triangles(t, i), v = skin_.triangles(t, j);
                if (u < v) continue;
                double* target = block(u, v, stride);
                const ElementHessian& element = elements[t];
                for (int c = 0; c < 6; ++c)
                    for (int r = 0; r < 6; ++r)
                        target[c * stride + r] += element(9 * (r / 3) + 3 * i + r % 3, 9 * (c / 3) + 3 * j + c % 3);
            }
    for (int v = 0; v < skin_.vertices.rows(); ++v) {
        for (Eigen::SparseMatrix<double>::InnerIterator it(bone_bending_, v); it; ++it) {
            if (it.row() < v) continue;
            double* target = block(static_cast<int>(it.row()), v, stride);
            for (int c = 0; c < 3; ++c) target[c * stride + c] += 2.0 * it.value();
        }
        for (Eigen::SparseMatrix<double>::InnerIterator it(muscle_bending_, v); it; ++it) {
            if (it.row() < v) continue;
            double* target = block(static_cast<int>(it.row()), v, stride);
            for (int c = 3; c < 6; ++c) target[c * stride + c] += 2.0 * it.value();
        }
        double* diagonal = block(v, v, stride);
        const double unit = ridge / (options.length_scale * options.length_scale);
        for (int c = 0; c < 6; ++c) diagonal[c * stride + c] += unit;
    }
    const double scale = 2.0 * options.boundary / (options.length_scale * options.length_scale);
    for (const Border& border : border_) {
        double* target = block(border.vertex, border.vertex, stride);
        for (int c = 0; c < 6; ++c)
            for (int r = 0; r < 6; ++r)
                if (c / 3 == r / 3) target[c * stride + r] += scale * border.normal[c % 3] * border.normal[r % 3];
    }
    return hessian_;
}

}  // namespace ndg
