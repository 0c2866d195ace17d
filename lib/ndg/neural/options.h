// SPDX-License-Identifier: Apache-2.0
// What can be chosen about the network and its training.
#pragma once

#include "ndg/body/posing.h"
#include "ndg/runtime/parametrisation_kind.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ndg {

/// Where tensors live.
enum class Device { cpu, cuda };
template <>
inline constexpr EnumName<Device> enum_table<Device>[] = {{Device::cpu, "cpu"}, {Device::cuda, "cuda"}};
/// Throws InputError for cuda where there is none.
void require_available(Device device);

/// The network (NDG section 4.4) and its ablations (Table 4).
struct NetworkOptions {
    /// Hidden layers; empty: one linear map.
    std::vector<int> widths = {4096, 4096, 600};
    /// What is predicted: a name in the table in output_space.cpp.
    std::string output_space = "residuals";
    ParametrisationKind parametrisation = ParametrisationKind::exponential;
    /// False: the network predicts F itself instead of R_p^T F ("no rotation"); in the root's frame.
    bool rotation = true;
    /// False: the network does not see the body ("no body shape").
    bool shape = true;
    /// 0: one network. n > 0: one for each region of the body (body_regions.h), which sees the joints at most n steps
    /// away in the kinematic tree; each has `widths` and `output_basis` of its own.
    int region_reach = 0;
    /// 0: the last layer is trained, as NDG's in the paper. k > 0: the last layer gives at most k coefficients of a
    /// fixed basis, principal components of the raw outputs that training asks for (output_basis.h): the PCA decoder of
    /// VertexNet; for residuals only with the parametrisations exponential and direct.
    int output_basis = 0;
    /// Share of the outputs' sum of squares after which the basis takes no more components.
    double output_basis_variance = 1.0;
    PosingOptions posing;  ///< of the training samples, which say it

    /// check_options, and what no range can say.
    void check() const;
};
void describe(OptionList& list, NetworkOptions& options);
/// Name in result tables: "NDG", "VertexNet", with what is left out or changed after it.
std::string method_name(const NetworkOptions& options);

/// Of the learning rate: as it is, to zero like a cosine, or halved after five epochs without a better validation loss.
enum class Schedule { constant, cosine, plateau };
template <>
inline constexpr EnumName<Schedule> enum_table<Schedule>[] = {
    {Schedule::constant, "constant"}, {Schedule::cosine, "cosine"}, {Schedule::plateau, "plateau"}};

/// Of the factors of products in training; weights, sums and all else are float32. automatic: bfloat16 where the
/// processor has matrix units for it (AMX).
enum class Precision { automatic, float32, bfloat16 };
template <>
inline constexpr EnumName<Precision> enum_table<Precision>[] = {
    {Precision::automatic, "auto"}, {Precision::float32, "float32"}, {Precision::bfloat16, "bfloat16"}};

/// float32 or bfloat16, automatic resolved for this machine. (Without AMX bfloat16 products are no faster: AVX512-BF16
/// multiplies twice as many numbers an instruction, half as often.) Throws InputError for bfloat16 where oneDNN lacks
/// it.
Precision resolve_precision(Precision precision, Device device);

/// More training samples made of those there are (augmentation.h); none in the paper.
struct AugmentationOptions {
    bool mirror = false;  ///< every other sample is seen in the mirror
    double splice = 0.0;  ///< share of the samples that take regions of another pose of the same body
    bool any() const { return mirror || splice > 0; }
};
void describe(OptionList& list, AugmentationOptions& options);

/// Training (NDG section 4.5).
struct TrainingOptions {
    int epochs = 102;
    int batch_size = 32;
    double learning_rate = 1.3e-3;
    double weight_decay = 0.01;  ///< of AdamW; on matrices only, not on biases and LayerNorm
    Schedule schedule = Schedule::constant;
    Precision precision = Precision::automatic;
    double dropout = 0.0;  ///< after each hidden layer, in training only
    /// Of the average of the weights, exponential in steps, that is validated and becomes the model; 0: the weights
    /// themselves.
    double weight_average = 0.0;
    double input_noise = 0.0;  ///< standard deviation of the noise added to the inputs that vary
    AugmentationOptions augmentation;
    int patience = 0;                  ///< stop after so many epochs without a better validation loss; 0: never
    double checkpoint_seconds = 60.0;  ///< at least; more where they would cost over 2 %. 0: after every epoch
    std::string checkpoint_path;       ///< empty: no checkpoints
    std::uint64_t seed = 0;
};
void describe(OptionList& list, TrainingOptions& options);

}  // namespace ndg
