// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/shape_space.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/io/h5.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

constexpr const char* format_name = "ndg-shape-space";
constexpr int format_version = 1;
/// Share of the largest eigenvalue below which a direction of the Gram matrix is rounding.
constexpr double rank_tolerance = 1e-13;
constexpr Eigen::Index block_rows = 2048;
/// How far stored (float32) components may be from orthonormal.
constexpr double orthonormal_tolerance = 1e-4;

Eigen::Map<const Eigen::VectorXd> flattened(const Eigen::Ref<const Points>& points)
{
    return {points.data(), points.size()};
}

/// Sets the sign of each column so that its largest entry (the first of equals) is positive.
void fix_signs(Eigen::MatrixXd& components)
{
    for (Eigen::Index c = 0; c < components.cols(); ++c) {
        Eigen::Index largest = 0;
        for (Eigen::Index i = 1; i < components.rows(); ++i) {
            if (std::abs(components(i, c)) > std::abs(components(largest, c))) largest = i;
        }
        if (components(largest, c) < 0.0) components.col(c) *= -1.0;
    }
}

/// Rows of the matrix that has one centred shape a column.
Eigen::MatrixXd centred_rows(const std::vector<const Points*>& shapes, const Eigen::VectorXd& mean, Eigen::Index row,
                             Eigen::Index rows)
{
    Eigen::MatrixXd block(rows, static_cast<Eigen::Index>(shapes.size()));
    for (Eigen::Index i = 0; i < block.cols(); ++i)
        block.col(i) = flattened(*shapes[i]).segment(row, rows) - mean.segment(row, rows);
    return block;
}

/// Inner products of the centred shapes, block by block, so that no second copy of all shapes is needed.
Eigen::MatrixXd gram_matrix(const std::vector<const Points*>& shapes, const Eigen::VectorXd& mean)
{
    const auto count = static_cast<Eigen::Index>(shapes.size());
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(count, count);
    for (Eigen::Index row = 0; row < mean.size(); row += block_rows) {
        const Eigen::MatrixXd block = centred_rows(shapes, mean, row, std::min(block_rows, mean.size() - row));
        gram.selfadjointView<Eigen::Lower>().rankUpdate(block.transpose());
    }
    return gram.selfadjointView<Eigen::Lower>();
}

/// The same of coordinates, for more shapes than coordinates.
Eigen::MatrixXd scatter_matrix(const std::vector<const Points*>& shapes, const Eigen::VectorXd& mean)
{
    Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(mean.size(), mean.size());
    for (const Points* shape : shapes) scatter.selfadjointView<Eigen::Lower>().rankUpdate(flattened(*shape) - mean);
    return scatter.selfadjointView<Eigen::Lower>();
}

/// C^T C v = v for a fixed vector v: fails for columns that are not orthonormal, at the cost of two products.
double orthonormality_defect(const Eigen::MatrixXd& components)
{
    Random random(0, "orthonormality");
    Eigen::VectorXd probe(components.cols());
    for (Eigen::Index i = 0; i < probe.size(); ++i) probe[i] = random.uniform(0.5, 1.5);
    return (components.transpose() * (components * probe) - probe).norm() / probe.norm();
}

}  // namespace

Eigen::VectorXd ShapeSpace::encode(const Eigen::Ref<const Points>& volume_vertices) const
{
    require(volume_vertices.size() == mean.size(), "A body of {} volume vertices was encoded in a space of {}",
            volume_vertices.rows(), mean.size() / 3);
    return components.transpose() * (flattened(volume_vertices) - mean);
}

Points ShapeSpace::decode(const Eigen::Ref<const Eigen::VectorXd>& code) const
{
    require(code.size() == components.cols(), "A code of {} numbers was decoded in a space of {}", code.size(),
            components.cols());
    const Eigen::VectorXd shape = mean + components * code;
    return Eigen::Map<const Points>(shape.data(), shape.size() / 3, 3);
}

ShapeSpace fit_shape_space(const std::vector<const Points*>& rest_shapes, int max_components, double variance)
{
    const auto count = static_cast<Eigen::Index>(rest_shapes.size());
    require_input(count >= 2, "A shape space needs at least two bodies, not {}", count);
    require_input(max_components >= 1 && variance > 0.0 && variance <= 1.0,
                  "A shape space cannot have {} components for a share {} of the variance", max_components, variance);
    const Eigen::Index num_coordinates = rest_shapes.front()->size();
    ShapeSpace space;
    space.mean = Eigen::VectorXd::Zero(num_coordinates);
    for (Eigen::Index i = 0; i < count; ++i) {
        const Points& shape = *rest_shapes[i];
        require(shape.size() == num_coordinates, "Body {} has {} coordinates, the first has {}", i, shape.size(),
                num_coordinates);
        require(shape.array().isFinite().all(), "Body {} has coordinates that are not finite", i);
        space.mean += flattened(shape) / static_cast<double>(count);
    }
    const bool by_bodies = count <= num_coordinates;
    const Eigen::MatrixXd products =
        by_bodies ? gram_matrix(rest_shapes, space.mean) : scatter_matrix(rest_shapes, space.mean);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(products);
    require(eigen.info() == Eigen::Success, "The principal components of {} bodies could not be computed", count);
    const Eigen::VectorXd eigenvalues = eigen.eigenvalues().reverse().cwiseMax(0.0);
    const double total = eigenvalues.sum();
    // Rounding of the mean alone is no variance.
    require_input(total > rank_tolerance * space.mean.squaredNorm() * std::numeric_limits<double>::epsilon(),
                  "The {} bodies of the shape space are all the same", count);

    Eigen::Index dimension = 0;
    double kept = 0.0;
    const Eigen::Index most = std::min<Eigen::Index>({max_components, count - 1, num_coordinates});
    while (dimension < most && kept < variance * total && eigenvalues[dimension] > rank_tolerance * eigenvalues[0]) {
        kept += eigenvalues[dimension++];
    }
    space.explained_variance = std::min(1.0, kept / total);
    space.standard_deviations = (eigenvalues.head(dimension) / static_cast<double>(count - 1)).cwiseSqrt();

    const Eigen::MatrixXd vectors = eigen.eigenvectors().rowwise().reverse().leftCols(dimension);
    if (by_bodies) {
        // Left singular vectors; the QR step removes what the squared condition of the Gram matrix cost in
        // orthogonality.
        Eigen::MatrixXd directions(num_coordinates, dimension);
        for (Eigen::Index row = 0; row < num_coordinates; row += block_rows) {
            const Eigen::Index rows = std::min(block_rows, num_coordinates - row);
            directions.middleRows(row, rows) = centred_rows(rest_shapes, space.mean, row, rows) * vectors;
        }
        const Eigen::HouseholderQR<Eigen::MatrixXd> qr(directions);
        space.components = qr.householderQ() * Eigen::MatrixXd::Identity(num_coordinates, dimension);
    } else {
        space.components = vectors;
    }
    fix_signs(space.components);
    return space;
}

Eigen::VectorXd explained_variances(const ShapeSpace& space)
{
    Eigen::VectorXd shares = space.standard_deviations.cwiseAbs2();
    for (Eigen::Index k = 1; k < shares.size(); ++k) shares[k] += shares[k - 1];
    return shares * (space.explained_variance / shares[shares.size() - 1]);
}

ReconstructionErrors reconstruction_errors(const ShapeSpace& space, const std::vector<const Points*>& rest_shapes,
                                           int dimension)
{
    require(dimension >= 1 && dimension <= space.dimension(), "{} components were asked of a shape space of {}",
            dimension, space.dimension());
    ReconstructionErrors errors;
    for (const Points* shape : rest_shapes) {
        Eigen::VectorXd code = space.encode(*shape);
        code.tail(space.dimension() - dimension).setZero();
        const Eigen::VectorXd distances = (space.decode(code) - *shape).rowwise().norm();
        errors.means.push_back(distances.mean());
        errors.largest = std::max(errors.largest, distances.maxCoeff());
    }
    return errors;
}

void write_shape_space(const std::string& path, const ShapeSpace& space, const Eigen::Ref<const RowMatrix>& codes,
                       const std::vector<double>& reconstruction_errors, const Provenance& provenance)
{
    require(codes.cols() == space.dimension() && static_cast<std::size_t>(codes.rows()) == reconstruction_errors.size(),
            "A shape space of {} components was given {} x {} codes and {} reconstruction errors", space.dimension(),
            codes.rows(), codes.cols(), reconstruction_errors.size());
    H5Writer writer(path, format_name, format_version, provenance);
    writer.attribute("explained_variance", space.explained_variance);
    writer.write("/shape_space/mean", std::vector<double>(space.mean.data(), space.mean.data() + space.mean.size()),
                 "mean rest shape, x y z of each volume vertex, m");
    writer.write("/shape_space/components", RowMatrix(space.components), "orthonormal components, one a column");
    writer.write("/shape_space/standard_deviations",
                 std::vector<double>(space.standard_deviations.data(),
                                     space.standard_deviations.data() + space.standard_deviations.size()),
                 "standard deviation of each training code, m");
    writer.write("/shape_space/codes", codes, "code of every body of the body file", Storage::float64);
    writer.write("/shape_space/reconstruction_errors", reconstruction_errors,
                 "mean distance of the decoded from the true volume vertices of every body, m");
    writer.commit();
}

ShapeSpace read_shape_space(const std::string& path)
{
    const H5Reader reader(path, format_name, format_version);
    ShapeSpace space;
    space.explained_variance = reader.attribute_double("explained_variance");
    const std::vector<double> mean = reader.read_doubles("/shape_space/mean");
    const auto num_coordinates = static_cast<Eigen::Index>(mean.size());
    require_input(num_coordinates > 0 && num_coordinates % 3 == 0,
                  "{}: /shape_space/mean has {} numbers, not three a vertex", path, num_coordinates);
    space.mean = Eigen::Map<const Eigen::VectorXd>(mean.data(), num_coordinates);
    space.components = reader.read_matrix("/shape_space/components", num_coordinates, -1);
    const std::vector<double> deviations = reader.read_doubles("/shape_space/standard_deviations", space.dimension());
    space.standard_deviations =
        Eigen::Map<const Eigen::VectorXd>(deviations.data(), static_cast<Eigen::Index>(deviations.size()));
    for (std::size_t i = 0; i < deviations.size(); ++i) {
        require_input(deviations[i] > 0.0, "{}: /shape_space/standard_deviations[{}] is {}, not positive", path, i,
                      deviations[i]);
    }
    require_input(space.dimension() > 0, "{}: /shape_space/components has no column", path);
    const double defect = orthonormality_defect(space.components);
    require_input(defect <= orthonormal_tolerance,
                  "{}: the columns of /shape_space/components are not orthonormal (defect {})", path, defect);
    return space;
}

}  // namespace ndg
