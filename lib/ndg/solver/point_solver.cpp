// SPDX-License-Identifier: Apache-2.0
#include "ndg/solver/point_solver.h"

#include "ndg/core/error.h"

#include <suitesparse/cholmod.h>

#include <algorithm>
#include <cmath>
#include <experimental/simd>
#include <numeric>

namespace ndg {
namespace {

namespace simd = std::experimental;
/// As wide on every machine, so that sums are the same on every machine.
constexpr int packet_size = 8;
using Packet = simd::simd<float, simd::simd_abi::deduce_t<float, packet_size>>;

/// Rows of a panel that are worked on together; panels are padded to a multiple of them.
constexpr int chunk_rows = 2 * packet_size;
/// More than the two cores this is made for, so that four have work too.
constexpr int num_parts = 4;
/// Parts are of the size of the mean and this share more at most, or as near as subtrees of less than...
constexpr double largest_excess = 0.03;
/// ... this share of the whole allow.
constexpr double smallest_subtree = 0.002;

void ignore_message(int, const char*, int, const char*) {}

int padded(int rows)
{
    return (rows + chunk_rows - 1) / chunk_rows * chunk_rows;
}

/// Columns of the chunk of a panel that begins at this row: what is right of the diagonal is zero and not kept.
int chunk_columns(int first_row, int num_columns)
{
    return std::min(num_columns, first_row + chunk_rows);
}

std::size_t panel_size(int num_rows, int num_columns)
{
    std::size_t size = 0;
    for (int row = 0; row < num_rows; row += chunk_rows)
        size += static_cast<std::size_t>(chunk_rows * chunk_columns(row, num_columns));
    return size;
}

Packet load(const float* from)
{
    return Packet(from, simd::element_aligned);
}

}  // namespace

struct PointSolver::Cholmod {
    Cholmod()
    {
        cholmod_start(&common);
        common.print = 0;
        common.error_handler = ignore_message;
        common.supernodal = CHOLMOD_SUPERNODAL;
        common.final_ll = 1;
        common.quick_return_if_not_posdef = 1;
        common.nmethods = 1;
        common.method[0].ordering = CHOLMOD_METIS;
        common.postorder = 1;
    }
    Cholmod(const Cholmod&) = delete;
    Cholmod& operator=(const Cholmod&) = delete;
    ~Cholmod()
    {
        cholmod_free_factor(&factor, &common);
        cholmod_finish(&common);
    }

    /// CHOLMOD only reads the arrays, which belong to the matrix.
    static cholmod_sparse view(const Eigen::SparseMatrix<double>& matrix)
    {
        if (matrix.rows() != matrix.cols() || !matrix.isCompressed())
            throw SolverError(
                fmt::format("a {} x {} matrix is not square or not compressed", matrix.rows(), matrix.cols()));
        cholmod_sparse view{};
        view.nrow = view.ncol = static_cast<std::size_t>(matrix.rows());
        view.nzmax = static_cast<std::size_t>(matrix.nonZeros());
        view.p = const_cast<int*>(matrix.outerIndexPtr());
        view.i = const_cast<int*>(matrix.innerIndexPtr());
        view.x = const_cast<double*>(matrix.valuePtr());
        view.stype = -1;
        view.itype = CHOLMOD_INT;
        view.xtype = CHOLMOD_REAL;
        view.dtype = CHOLMOD_DOUBLE;
        view.sorted = view.packed = 1;
        return view;
    }

    cholmod_common common{};
    cholmod_factor* factor = nullptr;
    std::size_t num_entries = 0;
};

PointSolver::PointSolver() = default;
PointSolver::~PointSolver() = default;
PointSolver::PointSolver(PointSolver&&) noexcept = default;
PointSolver& PointSolver::operator=(PointSolver&&) noexcept = default;

void PointSolver::analyze(const Eigen::SparseMatrix<double>& matrix)
{
    cholmod_ = std::make_unique<Cholmod>();
    cholmod_sparse view = Cholmod::view(matrix);
    cholmod_->factor = cholmod_analyze(&view, &cholmod_->common);
    if (cholmod_->factor == nullptr || cholmod_->common.status < CHOLMOD_OK || cholmod_->factor->is_super == 0)
        throw SolverError(fmt::format("CHOLMOD could not analyse a matrix of {} unknowns (status {})", matrix.rows(),
                                      cholmod_->common.status));
    cholmod_->num_entries = view.nzmax;
    const cholmod_factor& factor = *cholmod_->factor;
    const int* const first = static_cast<const int*>(factor.super);
    const int* const row_begin = static_cast<const int*>(factor.pi);
    const int* const rows = static_cast<const int*>(factor.s);
    const auto num_supernodes = static_cast<int>(factor.nsuper);
    std::vector<int> supernode_of(factor.n), parents(factor.nsuper, -1);
    std::vector<double> costs(factor.nsuper);
    supernodes_.assign(factor.nsuper, {});
    for (int s = 0; s < num_supernodes; ++s) {
        Supernode& node = supernodes_[s];
        node.first_column = first[s];
        node.num_columns = first[s + 1] - first[s];
        node.num_rows = row_begin[s + 1] - row_begin[s];
        node.source = s;
        costs[s] = static_cast<double>(panel_size(node.num_rows, node.num_columns));
        std::fill_n(supernode_of.begin() + first[s], node.num_columns, s);
    }
    for (int s = 0; s < num_supernodes; ++s)
        if (supernodes_[s].num_rows > supernodes_[s].num_columns)
            parents[s] = supernode_of[rows[row_begin[s] + supernodes_[s].num_columns]];
    arrange(parents, costs);

    const int* const permutation = static_cast<const int*>(factor.Perm);
    std::vector<int> position_of(factor.n);  // of CHOLMOD's columns
    unknown_at_.resize(factor.n);
    rows_.clear();
    std::size_t panel_begin = 0;
    int column = 0;
    for (Supernode& node : supernodes_) {
        for (int k = 0; k < node.num_columns; ++k) {
            position_of[first[node.source] + k] = column + k;
            unknown_at_[column + k] = permutation[first[node.source] + k];
        }
        node.first_column = column;
        node.panel_begin = panel_begin;
        column += node.num_columns;
        panel_begin += panel_size(node.num_rows, node.num_columns);
    }
    for (Supernode& node : supernodes_) {
        node.row_begin = rows_.size();
        for (int k = node.num_columns; k < node.num_rows; ++k)
            rows_.push_back(position_of[rows[row_begin[node.source] + k]]);
    }
    const Part& top = parts_.back();
    first_top_column_ =
        top.begin < top.end ? supernodes_[top.begin].first_column : static_cast<int>(unknown_at_.size());
    int most_rows = 0;
    for (const Supernode& node : supernodes_) most_rows = std::max(most_rows, padded(node.num_rows));
    for (Part& part : parts_) {
        part.lanes.resize(static_cast<std::size_t>(3 * (1 + packet_size) * most_rows));
        for (std::vector<float>& axis : part.of_top) axis.resize(unknown_at_.size() - first_top_column_);
    }
    panels_.resize(panel_begin);
    for (std::vector<float>& axis : x_) axis.resize(unknown_at_.size());
}

/// Sorts supernodes_ into parts: subtrees, the heaviest first to the lightest part, where subtrees are halved until the
/// parts are of nearly one size.
void PointSolver::arrange(const std::vector<int>& parents, const std::vector<double>& costs)
{
    const auto count = static_cast<int>(parents.size());
    std::vector<double> subtree = costs;  // parents come after their children
    std::vector<std::vector<int>> children(count);
    std::vector<int> roots;
    for (int s = 0; s < count; ++s) {
        if (parents[s] >= 0) {
            subtree[parents[s]] += subtree[s];
            children[parents[s]].push_back(s);
        } else {
            roots.push_back(s);
        }
    }
    const double total = std::accumulate(costs.begin(), costs.end(), 0.0);
    std::vector<int> part_of(count, num_parts);
    for (;;) {
        std::sort(roots.begin(), roots.end(),
                  [&](int a, int b) { return subtree[a] != subtree[b] ? subtree[a] > subtree[b] : a < b; });
        std::array<double, num_parts> loads = {};
        for (const int root : roots) {
            const auto lightest = std::min_element(loads.begin(), loads.end());
            part_of[root] = static_cast<int>(lightest - loads.begin());
            *lightest += subtree[root];
        }
        const double in_parts = std::accumulate(loads.begin(), loads.end(), 0.0);
        const bool balanced =
            *std::max_element(loads.begin(), loads.end()) * num_parts <= (1 + largest_excess) * in_parts;
        if (balanced || roots.empty() || subtree[roots.front()] < smallest_subtree * total) break;
        const int split = roots.front();
        part_of[split] = num_parts;
        roots.erase(roots.begin());
        roots.insert(roots.end(), children[split].begin(), children[split].end());
    }
    for (int s = count - 1; s >= 0; --s)
        if (part_of[s] == num_parts && parents[s] >= 0 && part_of[parents[s]] < num_parts)
            part_of[s] = part_of[parents[s]];
    std::stable_sort(supernodes_.begin(), supernodes_.end(),
                     [&](const Supernode& a, const Supernode& b) { return part_of[a.source] < part_of[b.source]; });
    parts_.assign(num_parts + 1, {});
    for (int i = 0; i < count; ++i) {
        Part& part = parts_[part_of[supernodes_[i].source]];
        if (part.end == 0) part.begin = i;
        part.end = i + 1;
    }
}

void PointSolver::factorize(const Eigen::SparseMatrix<double>& matrix)
{
    if (!cholmod_) throw SolverError("factorize was called before analyze");
    cholmod_sparse view = Cholmod::view(matrix);
    if (static_cast<int>(view.nrow) != num_unknowns() || view.nzmax != cholmod_->num_entries)
        throw SolverError("the matrix to factorise has another pattern than the analysed");
    for (std::size_t i = 0; i < view.nzmax; ++i)
        if (!std::isfinite(matrix.valuePtr()[i])) throw SolverError("the matrix to factorise has a non-finite value");
    cholmod_factorize(&view, cholmod_->factor, &cholmod_->common);
    const cholmod_factor& factor = *cholmod_->factor;
    if (cholmod_->common.status != CHOLMOD_OK || factor.minor < factor.n)
        throw SolverError(fmt::format("a matrix of {} unknowns is not positive definite", num_unknowns()));
    const double* const values = static_cast<const double*>(factor.x);
    const int* const value_begin = static_cast<const int*>(factor.px);
    for (const Supernode& node : supernodes_) {
        const Eigen::Map<const Eigen::MatrixXd> block(values + value_begin[node.source], node.num_rows,
                                                      node.num_columns);
        Eigen::MatrixXd panel(node.num_rows, node.num_columns);
        panel.topRows(node.num_columns).setIdentity();
        panel.bottomRows(node.num_rows - node.num_columns) = block.bottomRows(node.num_rows - node.num_columns);
        block.topRows(node.num_columns).triangularView<Eigen::Lower>().solveInPlace<Eigen::OnTheRight>(panel);
        float* to = panels_.data() + node.panel_begin;
        for (int row = 0; row < node.num_rows; row += chunk_rows)
            for (int column = 0; column < chunk_columns(row, node.num_columns); ++column)
                for (int lane = 0; lane < chunk_rows; ++lane, ++to)
                    *to = row + lane < node.num_rows ? static_cast<float>(panel(row + lane, column)) : 0.0F;
    }
}

/// x of the supernode's columns becomes what the forward substitution gives; rows below lose what these contribute.
void PointSolver::forward(const Supernode& node, Part& part, bool is_top)
{
    const float* panel = panels_.data() + node.panel_begin;
    const int stride = padded(node.num_rows);
    float* const products = part.lanes.data();  // three times the rows of the panel
    for (int row = 0; row < node.num_rows; row += chunk_rows) {
        std::array<Packet, 6> sums;
        for (Packet& sum : sums) sum = 0.0F;
        const int num_columns = chunk_columns(row, node.num_columns);
        for (int column = 0; column < num_columns; ++column, panel += chunk_rows) {
            const Packet low = load(panel), high = load(panel + packet_size);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const Packet x = x_[axis][node.first_column + column];
                sums[axis] += low * x;
                sums[3 + axis] += high * x;
            }
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            sums[axis].copy_to(products + axis * stride + row, simd::element_aligned);
            sums[3 + axis].copy_to(products + axis * stride + row + packet_size, simd::element_aligned);
        }
    }
    const int* const rows = rows_.data() + node.row_begin;
    const int num_below = node.num_rows - node.num_columns;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float* const product = products + axis * stride;
        std::copy_n(product, node.num_columns, x_[axis].data() + node.first_column);
        float* const own = x_[axis].data();
        float* const top = is_top ? own + first_top_column_ : part.of_top[axis].data();
        const float* const below = product + node.num_columns;
        for (int k = 0; k < num_below; ++k) {
            const int position = rows[k];
            float& target = position < first_top_column_ ? own[position] : top[position - first_top_column_];
            target -= below[k];
        }
    }
}

/// x of the supernode's columns becomes the solution, that of the rows below being known.
void PointSolver::backward(const Supernode& node, Part& part)
{
    const int stride = padded(node.num_rows);
    float* const known = part.lanes.data();
    const int* const rows = rows_.data() + node.row_begin;
    const int num_below = node.num_rows - node.num_columns;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float* const x = x_[axis].data();
        float* const to = known + axis * stride;
        std::copy_n(x + node.first_column, node.num_columns, to);
        for (int k = 0; k < num_below; ++k) to[node.num_columns + k] = -x[rows[k]];
        std::fill(to + node.num_rows, to + stride, 0.0F);
    }
    float* const sums = known + 3 * stride;  // a packet an axis and column
    std::fill_n(sums, 3 * packet_size * node.num_columns, 0.0F);
    const float* panel = panels_.data() + node.panel_begin;
    for (int row = 0; row < node.num_rows; row += chunk_rows) {
        std::array<Packet, 6> x;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            x[axis] = load(known + axis * stride + row);
            x[3 + axis] = load(known + axis * stride + row + packet_size);
        }
        const int num_columns = chunk_columns(row, node.num_columns);
        float* sum = sums;
        for (int column = 0; column < num_columns; ++column, panel += chunk_rows) {
            const Packet low = load(panel), high = load(panel + packet_size);
            for (std::size_t axis = 0; axis < 3; ++axis, sum += packet_size)
                Packet(load(sum) + low * x[axis] + high * x[3 + axis]).copy_to(sum, simd::element_aligned);
        }
    }
    for (int column = 0; column < node.num_columns; ++column)
        for (std::size_t axis = 0; axis < 3; ++axis)
            x_[axis][node.first_column + column] = simd::reduce(load(sums + (3 * column + axis) * packet_size));
}

void PointSolver::solve(Eigen::Ref<Eigen::Matrix4Xf> points)
{
    const int count = num_unknowns();
    if (points.cols() != count || panels_.empty())
        throw SolverError(fmt::format("no factor for right-hand sides of {} unknowns", points.cols()));
#pragma omp parallel
    {
#pragma omp for schedule(static)
        for (int i = 0; i < count; ++i)
            for (int axis = 0; axis < 3; ++axis) x_[axis][i] = points(axis, unknown_at_[i]);
#pragma omp for schedule(dynamic, 1)
        for (int p = 0; p < num_parts; ++p) {
            Part& part = parts_[p];
            for (std::vector<float>& axis : part.of_top) std::fill(axis.begin(), axis.end(), 0.0F);
            for (int s = part.begin; s < part.end; ++s) forward(supernodes_[s], part, false);
        }
#pragma omp single
        {
            for (std::size_t axis = 0; axis < 3; ++axis)
                for (int p = 0; p < num_parts; ++p)
                    for (std::size_t i = 0; i < parts_[p].of_top[axis].size(); ++i)
                        x_[axis][first_top_column_ + i] += parts_[p].of_top[axis][i];
            Part& top = parts_.back();
            for (int s = top.begin; s < top.end; ++s) forward(supernodes_[s], top, true);
            for (int s = top.end - 1; s >= top.begin; --s) backward(supernodes_[s], top);
        }
#pragma omp for schedule(dynamic, 1)
        for (int p = 0; p < num_parts; ++p)
            for (int s = parts_[p].end - 1; s >= parts_[p].begin; --s) backward(supernodes_[s], parts_[p]);
#pragma omp for schedule(static)
        for (int i = 0; i < count; ++i)
            for (int axis = 0; axis < 3; ++axis) points(axis, unknown_at_[i]) = x_[axis][i];
    }
}

}  // namespace ndg
