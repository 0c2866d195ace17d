// SPDX-License-Identifier: Apache-2.0
// From a term's elements to an objective's unknowns: numbering, sparsity pattern, places of the entries in it.
#pragma once

#include "ndg/elastic/stencils.h"

#include <Eigen/SparseCore>

#include <vector>

namespace ndg {

class SparsityPattern;

/// A term's elements that have an unknown vertex, and where their entries go in gradient and Hessian of an objective.
class ElementPlaces {
public:
    /// `vertices`: the unknown ones, ascending.
    ElementPlaces(const Stencils& stencils, const std::vector<int>& vertices);
    /// Fills stride and block.
    void find_blocks(const SparsityPattern& pattern);

    int size() const { return static_cast<int>(records_.size()) / record_length_; }
    int num_corners() const { return num_corners_; }
    /// The i th one's index among all elements of the term.
    int element(int i) const { return records_[record_length_ * i]; }
    /// Per corner: its vertex's place among the unknown ones, -1 where it is held.
    const int* unknown(int i) const { return &records_[record_length_ * i + 1]; }
    /// Per corner: values of the matrix from one column of its vertex to the next.
    const int* stride(int i) const { return unknown(i) + num_corners_; }
    /// Block (a, b), a >= b, of the element's Hessian is the a (a + 1) / 2 + b th: the index among the matrix's values
    /// of its top left entry, -1 where it is not stored. Where corner a comes before b among the unknown vertices it is
    /// stored transposed.
    const int* block(int i) const { return unknown(i) + 2 * num_corners_; }

private:
    int num_corners_, record_length_;
    std::vector<int> records_;  ///< of every element in turn: all of the above
};

/// Vertices that have an element in common, and the lower triangle of a matrix with a 3 x 3 block for each two of them,
/// diagonal blocks full.
class SparsityPattern {
public:
    SparsityPattern(int num_unknown_vertices, const std::vector<ElementPlaces>& terms);

    int num_values() const { return 9 * begin_.back(); }
    /// Zero.
    Eigen::SparseMatrix<double> matrix() const;
    /// Values from one column of vertex v to the next.
    int stride(int v) const { return 3 * (begin_[v + 1] - begin_[v]); }
    /// Index among the values of the top left entry of the block at vertices row >= column; there must be one.
    int block(int row, int column) const;

private:
    std::vector<int> rows_;   ///< of every vertex in turn: itself and its later neighbours, sorted
    std::vector<int> begin_;  ///< per vertex: its first among rows_, and the end
};

}  // namespace ndg
