// SPDX-License-Identifier: Apache-2.0
// Four elements side by side: every number of a kernel is a vector register with one element a lane.
#pragma once

#include <array>
#include <cstddef>
#include <experimental/simd>

namespace ndg {

constexpr std::size_t num_lanes = 4;
using Lanes =
    std::experimental::simd<double, std::experimental::simd_abi::deduce_t<double, static_cast<int>(num_lanes)>>;

inline Lanes load_lanes(const double* values)
{
    return Lanes(values, std::experimental::element_aligned);
}

/// value(item) of every lane's item.
template <class Item, class Value>
Lanes gather_lanes(const std::array<Item, num_lanes>& items, const Value& value)
{
    const std::array<double, num_lanes> values{value(items[0]), value(items[1]), value(items[2]), value(items[3])};
    return load_lanes(values.data());
}

struct Lanes3 {
    std::array<Lanes, 3> c;
    Lanes& operator[](std::size_t i) { return c[i]; }
    const Lanes& operator[](std::size_t i) const { return c[i]; }
};

inline Lanes3 operator+(const Lanes3& a, const Lanes3& b)
{
    return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}};
}
inline Lanes3 operator-(const Lanes3& a, const Lanes3& b)
{
    return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}};
}
inline Lanes3 operator*(const Lanes& s, const Lanes3& a)
{
    return {{s * a[0], s * a[1], s * a[2]}};
}
inline Lanes dot(const Lanes3& a, const Lanes3& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Lanes3 cross(const Lanes3& a, const Lanes3& b)
{
    return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

/// Stacked vectors of the four elements; entry k of lane i is values[num_lanes k + i].
template <std::size_t Size>
struct LaneVector {
    alignas(sizeof(Lanes)) std::array<double, Size * num_lanes> values;

    LaneVector() {}  // not zero, wherever it is made
    Lanes get(std::size_t k) const { return Lanes(&values[num_lanes * k], std::experimental::vector_aligned); }
    void set(std::size_t k, const Lanes& value)
    {
        value.copy_to(&values[num_lanes * k], std::experimental::vector_aligned);
    }
    void set3(std::size_t vertex, const Lanes3& value)
    {
        for (std::size_t c = 0; c < 3; ++c) set(3 * vertex + c, value[c]);
    }
};

/// Lower triangle of symmetric matrices in 3 x 3 blocks of `Size` vertices: block (a, b), a >= b, is the
/// a (a + 1) / 2 + b th, each column by column and full.
template <std::size_t Size>
struct LaneBlocks : LaneVector<9 * Size*(Size + 1) / 2> {
    static constexpr std::size_t at(std::size_t a, std::size_t b) { return 9 * (a * (a + 1) / 2 + b); }

    /// One lane from a symmetric matrix of 3 Size rows, anything with (row, column).
    template <class Matrix>
    void set_lane(std::size_t lane, const Matrix& matrix)
    {
        for (std::size_t a = 0; a < Size; ++a) {
            for (std::size_t b = 0; b <= a; ++b) {
                for (std::size_t k = 0; k < 9; ++k) {
                    this->values[num_lanes * (at(a, b) + k) + lane] =
                        matrix(static_cast<int>(3 * a + k % 3), static_cast<int>(3 * b + k / 3));
                }
            }
        }
    }

    /// Adds left[a] right[b]^T to every block, or sets it.
    template <bool Set = false>
    void add_products(const std::array<Lanes3, Size>& left, const std::array<Lanes3, Size>& right)
    {
        for (std::size_t a = 0; a < Size; ++a) {
            for (std::size_t b = 0; b <= a; ++b) {
                for (std::size_t j = 0; j < 3; ++j) {
                    for (std::size_t i = 0; i < 3; ++i) {
                        const std::size_t k = at(a, b) + i + 3 * j;
                        if (Set) {
                            this->set(k, left[a][i] * right[b][j]);
                        } else {
                            this->set(k, this->get(k) + left[a][i] * right[b][j]);
                        }
                    }
                }
            }
        }
    }
};

/// Rotates the columns of w, `Size` vectors of length Size, until they are orthogonal (one-sided Jacobi, Hestenes
/// 1958), and the columns of v, where given, with them: w becomes U S of the singular value decomposition, v is
/// multiplied by its V. What is left of w^T w beside its diagonal is some 1e-10 |w| (|p| + |q|) at most for columns p
/// and q.
template <std::size_t Size>
void orthogonalise(std::array<std::array<Lanes, Size>, Size>& w, std::array<Lanes3, 3>* v = nullptr)
{
    constexpr int max_sweeps = 30;
    constexpr double last_sweep = 1e-10, skipped = 1e-12;
    // Every sweep goes through all pairs as rounds of a tournament: the pairs of a round share no column, so that their
    // angles do not wait for each other.
    constexpr std::size_t rounds = Size % 2 == 0 ? Size - 1 : Size, pairs = Size / 2;
    std::array<Lanes, Size> squared;
    bool done = false;
    for (int sweep = 0; sweep < max_sweeps && !done; ++sweep) {
        done = true;
        Lanes scale = 0.0;
        for (std::size_t p = 0; p < Size; ++p) {
            squared[p] = w[p][0] * w[p][0];
            for (std::size_t i = 1; i < Size; ++i) squared[p] += w[p][i] * w[p][i];
            scale += squared[p];
        }
        for (std::size_t round = 0; round < rounds; ++round) {
            std::array<std::size_t, pairs> first, second;
            std::array<Lanes, pairs> cosine, sine;
            bool turned = false;
            for (std::size_t k = 0; k < pairs; ++k) {
                const std::size_t offset = Size % 2 == 0 ? k : k + 1;
                first[k] = (round + offset) % rounds;
                second[k] = offset == 0 ? Size - 1 : (round + rounds - offset) % rounds;
                const auto& p = w[first[k]];
                const auto& q = w[second[k]];
                Lanes& pp = squared[first[k]];
                Lanes& qq = squared[second[k]];
                Lanes product = p[0] * q[0];
                for (std::size_t i = 1; i < Size; ++i) product += p[i] * q[i];
                const Lanes share = product * product, bound = scale * (pp + qq);
                turned = turned || any_of(share > skipped * skipped * bound);
                done = done && none_of(share > last_sweep * last_sweep * bound);
                const Lanes x = qq - pp, y = 2.0 * product;
                Lanes divisor = x + copysign(sqrt(x * x + y * y), x);
                where(divisor == 0.0, divisor) = 1.0;
                const Lanes tangent = y / divisor;
                cosine[k] = 1.0 / sqrt(1.0 + tangent * tangent);
                sine[k] = cosine[k] * tangent;
                pp -= tangent * product;
                qq += tangent * product;
            }
            if (!turned) continue;
            for (std::size_t k = 0; k < pairs; ++k) {
                const auto turn = [&](Lanes& p, Lanes& q) {
                    const Lanes other = cosine[k] * p - sine[k] * q;
                    q = sine[k] * p + cosine[k] * q;
                    p = other;
                };
                for (std::size_t i = 0; i < Size; ++i) turn(w[first[k]][i], w[second[k]][i]);
                for (std::size_t i = 0; v != nullptr && i < 3; ++i) turn((*v)[first[k]][i], (*v)[second[k]][i]);
            }
        }
    }
}

}  // namespace ndg
