// SPDX-License-Identifier: Apache-2.0
#include "ndg/fem/sample_parts.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/io/h5.h"

#include <filesystem>
#include <limits>
#include <utility>

namespace ndg {

namespace {

namespace fs = std::filesystem;

const std::string part_format = "ndg-fem-part";
constexpr int part_version = 1;

}  // namespace

const std::vector<std::string>& simulation_statistics()
{
    static const std::vector<std::string> names = {"energy_joule", "residual_newton", "residual_relative", "iterations",
                                                   "converged",    "load_steps",      "inverted_prisms",   "seconds"};
    return names;
}

PartFolder::PartFolder(const std::string& output, std::string key, int num_volume_vertices)
    : path_(output + ".parts"), key_(std::move(key)), num_volume_vertices_(num_volume_vertices)
{
    std::error_code error;
    fs::create_directories(path_, error);
    require_input(!error && fs::is_directory(path_), "{}: the folder for finished samples could not be made ({})",
                  path_, error.message());
}

std::string PartFolder::part_path(int sample_idx) const
{
    return fmt::format("{}/{:06d}.h5", path_, sample_idx);
}

void PartFolder::write(int sample_idx, const SamplePart& part, const Provenance& provenance) const
{
    H5Writer file(part_path(sample_idx), part_format, part_version, provenance);
    file.attribute("key", key_);
    for (const auto& [name, value] : part.statistics) file.attribute(name, value);
    file.write("/sample/pair", std::vector<int>{part.pair.body_idx, part.pair.pose_idx}, "body and pose");
    file.write("/sample/vertices", {1, static_cast<std::size_t>(num_volume_vertices_), 3}, part.vertices.data(),
               "deformed volume vertices");
    file.commit();
}

std::optional<SamplePart> PartFolder::read(int sample_idx, const SamplePair& pair) const
{
    const std::string path = part_path(sample_idx);
    if (!fs::exists(path)) return std::nullopt;
    try {
        const H5Reader file(path, part_format, part_version);
        if (file.attribute("key") != key_) return std::nullopt;
        const std::vector<int> indices = file.read_ints("/sample/pair", 2, 0, std::numeric_limits<int>::max());
        if (indices[0] != pair.body_idx || indices[1] != pair.pose_idx) return std::nullopt;
        const std::vector<std::size_t> expected = {1, static_cast<std::size_t>(num_volume_vertices_), 3};
        if (file.shape("/sample/vertices") != expected) return std::nullopt;
        SamplePart part;
        part.pair = pair;
        part.vertices = file.read_slice("/sample/vertices", 0);
        for (const std::string& name : simulation_statistics()) part.statistics[name] = file.attribute_double(name);
        return part;
    } catch (const InputError& error) {
        log_warning("a part is simulated again: {}", error.what());
        return std::nullopt;
    }
}

void PartFolder::remove() const
{
    std::error_code error;
    fs::remove_all(path_, error);
    if (error) log_warning("{}: the folder of finished samples could not be removed ({})", path_, error.message());
}

}  // namespace ndg
