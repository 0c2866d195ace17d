// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/enum_names.h"

namespace ndg {

/// How the nine numbers Q a prism become its residual. All give the identity for Q = 0. exponential: exp(Q), NDG
/// equation 15. direct: I + Q ("no matrix exp"). lu: unit lower times upper triangular with the exponentials of Q's
/// diagonal. qr: rotation (exponential of the skew part given by Q's lower triangle) times such an upper triangular
/// matrix.
enum class ParametrisationKind { exponential, direct, lu, qr };
template <>
inline constexpr EnumName<ParametrisationKind> enum_table<ParametrisationKind>[] = {
    {ParametrisationKind::exponential, "exponential"},
    {ParametrisationKind::direct, "direct"},
    {ParametrisationKind::lu, "lu"},
    {ParametrisationKind::qr, "qr"}};

}  // namespace ndg
