// SPDX-License-Identifier: Apache-2.0
// What can be chosen about the network and its training.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ndg {

/// Where tensors live.
enum class Device { cpu, cuda };
/// "cpu" or "cuda"; throws InputError for anything else, and for "cuda" where there is none.
Device parse_device(const std::string& name);

/// How the nine numbers Q a prism become its residual. All give the identity for Q = 0.
inline const std::vector<std::string> parametrisation_names = {"exponential", "direct", "lu", "qr"};

/// The network (NDG section 4.4) and its ablations (Table 4).
struct NetworkOptions {
    /// Hidden layers; empty: one linear map.
    std::vector<int> widths = {4096, 4096, 600};
    /// What is predicted: a name in the table in output_space.cpp.
    std::string output_space = "residuals";
    /// exponential: exp(Q), equation 15. direct: I + Q ("no matrix exp"). lu: unit lower times upper triangular with
    /// the exponentials of Q's diagonal. qr: rotation (exponential of the skew part given by Q's lower triangle) times
    /// such an upper triangular matrix.
    std::string parametrisation = "exponential";
    /// False: the network predicts F itself instead of R_p^T F ("no rotation"); in the root's frame, see features.h.
    bool rotation = true;
    /// False: the network does not see the body ("no body shape").
    bool shape = true;
    /// 0: the last layer is trained, as in the paper. k > 0: the last layer gives k coefficients of a fixed basis, the
    /// k principal components of the training residuals' logarithms (output_basis.h); for small data sets. Only with
    /// the parametrisations exponential and direct.
    int output_basis = 0;

    /// Throws InputError naming the option and its value.
    void check() const;
};

/// Training (NDG section 4.5).
struct TrainingOptions {
    int epochs = 102;
    int batch_size = 32;
    double learning_rate = 1.3e-3;
    double weight_decay = 0.01;         ///< of AdamW; on matrices only, not on biases and LayerNorm
    std::string schedule = "constant";  ///< "constant", "cosine" (to zero) or "plateau" (halved after 5 bad epochs)
    double dropout = 0.0;               ///< after each hidden layer, in training only
    double input_noise = 0.0;           ///< standard deviation of the noise added to the inputs that vary
    int patience = 0;                   ///< stop after so many epochs without a better validation loss; 0: never
    double checkpoint_seconds = 60.0;   ///< 0: after every epoch
    std::string checkpoint_path;        ///< empty: no checkpoints
    std::uint64_t seed = 0;

    /// Throws InputError naming the option and its value.
    void check() const;
};
inline const std::vector<std::string> schedule_names = {"constant", "cosine", "plateau"};

}  // namespace ndg
