// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/runtime_model.h"

#include "ndg/core/error.h"
#include "ndg/core/stream_file.h"
#include "ndg/io/licences.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <utility>

namespace ndg {
namespace {

using nlohmann::json;

constexpr char magic[] = "ndg-runtime";  // with its zero 12 bytes
constexpr std::uint32_t version = 1;
/// Magic, version and length of the JSON text.
constexpr std::size_t head_bytes = sizeof(magic) + sizeof(std::uint32_t) + sizeof(std::uint64_t);
constexpr std::uint64_t page = 4096;

std::uint64_t to_pages(std::uint64_t size)
{
    return (size + page - 1) / page * page;
}

std::uint64_t layer_bytes(const RuntimeLayer& layer)
{
    return static_cast<std::uint64_t>(num_weight_blocks(layer.num_rows)) *
           weight_block_bytes(layer.storage, layer.num_columns);
}

/// Numbers of the shape space: mean, standard deviations, components column by column, at the beginning of the data.
std::uint64_t shape_space_bytes(Eigen::Index num_coordinates, Eigen::Index dimension)
{
    return sizeof(double) * static_cast<std::uint64_t>(num_coordinates + dimension + num_coordinates * dimension);
}

/// Calls f(numbers, count) for what the file holds of a shape space, in its order.
template <typename Space, typename F>
void for_numbers(Space& space, const F& f)
{
    f(space.mean.data(), space.mean.size());
    f(space.standard_deviations.data(), space.standard_deviations.size());
    f(space.components.data(), space.components.size());
}

json describe_model(const RuntimeDescription& model, const Provenance& provenance)
{
    json inputs = json::array(), parts = json::array();
    for (const Provenance::Input& input : provenance.inputs)
        inputs.push_back({{"path", input.path}, {"sha256", input.sha256}});
    for (const RuntimePart& part : model.parts) {
        json layers = json::array();
        for (const RuntimeLayer& layer : part.layers)
            layers.push_back({{"rows", layer.num_rows},
                              {"columns", layer.num_columns},
                              {"storage", to_name(layer.storage)},
                              {"offset", layer.offset},
                              {"norm_weight", layer.norm_weight},
                              {"norm_bias", layer.norm_bias}});
        parts.push_back({{"inputs", part.inputs}, {"prisms", part.prisms}, {"layers", layers}});
    }
    return {{"created_by", {{"tool", provenance.tool}, {"version", project_version()}, {"commit", project_commit()}}},
            {"config", json::parse(provenance.config_json)},
            {"inputs", inputs},
            {"licences", merged_licences(provenance)},
            {"template_sha256", model.template_sha256},
            {"bone_wrap", to_name(model.traits.posing.bone_wrap)},
            {"output_space", model.traits.output_space},
            {"parametrisation", to_name(model.traits.parametrisation)},
            {"rotation", model.traits.rotation},
            {"shape", model.traits.shape},
            {"joint_names", model.joint_names},
            {"visible_joints", model.visible_joints},
            {"shape_space",
             {{"coordinates", model.shape_space.mean.size()},
              {"dimension", model.shape_space.dimension()},
              {"explained_variance", model.shape_space.explained_variance}}},
            {"parts", parts}};
}

RuntimeDescription parse_model(const json& head)
{
    RuntimeDescription model;
    model.template_sha256 = head.at("template_sha256").get<std::string>();
    model.traits.posing.bone_wrap = parse_name<BoneWrap>(head.at("bone_wrap").get<std::string>(), "bone_wrap");
    model.traits.output_space = head.at("output_space").get<std::string>();
    model.traits.parametrisation =
        parse_name<ParametrisationKind>(head.at("parametrisation").get<std::string>(), "parametrisation");
    model.traits.rotation = head.at("rotation").get<bool>();
    model.traits.shape = head.at("shape").get<bool>();
    model.joint_names = head.at("joint_names").get<std::vector<std::string>>();
    model.visible_joints = head.at("visible_joints").get<std::vector<int>>();
    const json& space = head.at("shape_space");
    model.shape_space.explained_variance = space.at("explained_variance").get<double>();
    const auto coordinates = space.at("coordinates").get<int>(), dimension = space.at("dimension").get<int>();
    require(coordinates >= 0 && dimension >= 0, "the shape space has {} x {} numbers", coordinates, dimension);
    model.shape_space.mean.resize(coordinates);
    model.shape_space.standard_deviations.resize(dimension);
    model.shape_space.components.resize(coordinates, dimension);
    for (const json& part_json : head.at("parts")) {
        RuntimePart part;
        part.inputs = part_json.at("inputs").get<std::vector<int>>();
        part.prisms = part_json.at("prisms").get<std::vector<int>>();
        for (const json& layer_json : part_json.at("layers")) {
            RuntimeLayer layer;
            layer.num_rows = layer_json.at("rows").get<int>();
            layer.num_columns = layer_json.at("columns").get<int>();
            layer.storage = parse_name<WeightStorage>(layer_json.at("storage").get<std::string>(), "storage");
            layer.offset = layer_json.at("offset").get<std::uint64_t>();
            layer.norm_weight = layer_json.at("norm_weight").get<std::vector<float>>();
            layer.norm_bias = layer_json.at("norm_bias").get<std::vector<float>>();
            part.layers.push_back(std::move(layer));
        }
        model.parts.push_back(std::move(part));
    }
    return model;
}

/// The whole file, read-only; its pages come from the disk when they are first used.
std::shared_ptr<const std::byte> map_file(const std::string& path, std::size_t& size)
{
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    require_input(file >= 0, "{}: cannot be opened ({})", path, std::strerror(errno));
    struct stat status = {};
    const bool is_file = ::fstat(file, &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0;
    size = is_file ? static_cast<std::size_t>(status.st_size) : 0;
    void* const begin = is_file ? ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file, 0) : MAP_FAILED;
    ::close(file);
    require_input(begin != MAP_FAILED, "{}: cannot be mapped into memory", path);
    return {static_cast<const std::byte*>(begin),
            [size](const std::byte* mapped) { ::munmap(const_cast<std::byte*>(mapped), size); }};
}

}  // namespace

int RuntimeDescription::num_prisms() const
{
    int count = 0;
    for (const RuntimePart& part : parts)
        for (const int prism : part.prisms) count += prism >= 0 ? 1 : 0;
    return count;
}

void RuntimeDescription::check() const
{
    require(!parts.empty(), "the network has no parts");
    require(joint_names.size() == visible_joints.size(), "{} joint names and {} marks of visible joints",
            joint_names.size(), visible_joints.size());
    require(shape_space.components.rows() == shape_space.mean.size() &&
                shape_space.components.cols() == shape_space.standard_deviations.size(),
            "the shape space's mean, components and deviations differ in size");
    const int num_features = 9 * static_cast<int>(joint_names.size()) + (traits.shape ? shape_space.dimension() : 0);
    const int count = num_prisms();
    std::vector<char> is_given(static_cast<std::size_t>(count), 0);
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const RuntimePart& part = parts[p];
        require(!part.layers.empty() && part.prisms.size() % group_prisms == 0 && !part.prisms.empty(),
                "part {} has {} layers and {} prisms", p, part.layers.size(), part.prisms.size());
        for (const int input : part.inputs)
            require(input >= 0 && input < num_features, "part {} sees input {} of {}", p, input, num_features);
        for (const int prism : part.prisms) {
            if (prism == -1) continue;
            require(prism >= 0 && prism < count && is_given[prism] == 0, "part {} gives prism {}", p, prism);
            is_given[prism] = 1;
        }
        int columns = static_cast<int>(part.inputs.size());
        for (std::size_t i = 0; i < part.layers.size(); ++i) {
            const RuntimeLayer& layer = part.layers[i];
            const auto rows = static_cast<std::size_t>(std::max(layer.num_rows, 0));
            require(layer.num_columns == columns && layer.num_rows > 0 &&
                        layer.norm_weight.size() == layer.norm_bias.size() &&
                        (layer.norm_weight.empty() || layer.norm_weight.size() == rows),
                    "layer {} of part {} is {} x {} where its input has {} numbers", i, p, layer.num_rows,
                    layer.num_columns, columns);
            columns = layer.num_rows;
        }
        require(columns == 9 * static_cast<int>(part.prisms.size()) && part.layers.back().norm_weight.empty(),
                "part {} gives {} numbers for {} prisms", p, columns, part.prisms.size());
    }
}

RuntimeModel::RuntimeModel(const std::string& path) : path_(path)
{
    std::size_t size = 0;
    mapping_ = map_file(path, size);
    const std::byte* const begin = mapping_.get();
    std::uint32_t found_version = 0;
    std::uint64_t text_length = 0;
    require_input(size >= head_bytes && std::memcmp(begin, magic, sizeof(magic)) == 0,
                  "{}: is no runtime model; export-runtime makes one of a trained network", path);
    std::memcpy(&found_version, begin + sizeof(magic), sizeof(found_version));
    std::memcpy(&text_length, begin + sizeof(magic) + sizeof(found_version), sizeof(text_length));
    require_input(found_version == version, "{}: has version {} of the runtime model, this program reads {}", path,
                  found_version, version);
    require_input(text_length <= size - head_bytes, "{}: is cut off", path);
    head_.assign(reinterpret_cast<const char*>(begin + head_bytes), text_length);
    try {
        static_cast<RuntimeDescription&>(*this) = parse_model(json::parse(head_));
        check();
    } catch (const json::exception& error) {
        throw InputError(fmt::format("{}: its head is damaged ({})", path, error.what()));
    } catch (const Error& error) {
        throw InputError(fmt::format("{}: {}", path, error.what()));
    }
    const std::uint64_t data_begin = to_pages(head_bytes + text_length);
    const std::byte* numbers = begin + data_begin;
    require_input(
        data_begin <= size && shape_space_bytes(shape_space.mean.size(), shape_space.dimension()) <= size - data_begin,
        "{}: is cut off", path);
    for_numbers(shape_space, [&](double* values, Eigen::Index count) {
        std::memcpy(values, numbers, sizeof(double) * static_cast<std::size_t>(count));
        numbers += sizeof(double) * static_cast<std::size_t>(count);
    });
    for (RuntimePart& part : parts)
        for (RuntimeLayer& layer : part.layers) {
            require_input(layer.offset % page == 0 && layer.offset <= size - data_begin &&
                              layer_bytes(layer) <= size - data_begin - layer.offset,
                          "{}: is cut off, or a layer lies outside of it", path);
            layer.blocks = begin + data_begin + layer.offset;
        }
}

void RuntimeModel::check_weights() const
{
    const ShapeSpace& space = shape_space;
    require_input(space.mean.allFinite() && space.components.allFinite() && space.standard_deviations.allFinite(),
                  "{}: a number of the shape space is not finite", path_);
    for (std::size_t p = 0; p < parts.size(); ++p)
        for (std::size_t i = 0; i < parts[p].layers.size(); ++i) {
            const RuntimeLayer& layer = parts[p].layers[i];
            const std::size_t bytes = weight_block_bytes(layer.storage, layer.num_columns);
            for (int b = 0; b < num_weight_blocks(layer.num_rows); ++b)
                require_input(is_finite_block(layer.storage, layer.num_columns,
                                              layer.blocks + bytes * static_cast<std::size_t>(b)),
                              "{}: block {} of layer {} of part {} is not finite", path_, b, i, p);
        }
}

std::size_t RuntimeModel::weight_bytes() const
{
    std::size_t bytes = 0;
    for (const RuntimePart& part : parts)
        for (const RuntimeLayer& layer : part.layers) bytes += layer_bytes(layer);
    return bytes;
}

std::int64_t RuntimeModel::num_weights() const
{
    std::int64_t count = 0;
    for (const RuntimePart& part : parts)
        for (const RuntimeLayer& layer : part.layers)
            count += static_cast<std::int64_t>(layer.num_rows) * layer.num_columns;
    return count;
}

void write_runtime_model(const std::string& path, const RuntimeDescription& model, const BlockSource& source,
                         const Provenance& provenance)
{
    model.check();
    RuntimeDescription described = model;
    const std::uint64_t space_bytes = shape_space_bytes(model.shape_space.mean.size(), model.shape_space.dimension());
    std::uint64_t offset = to_pages(space_bytes);
    for (RuntimePart& part : described.parts)
        for (RuntimeLayer& layer : part.layers) {
            layer.offset = offset;
            offset = to_pages(offset + layer_bytes(layer));
        }
    const std::string text = describe_model(described, provenance).dump();
    write_stream(path, [&](std::ostream& file) {
        const auto put = [&](const void* data, std::size_t size) {
            file.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
        };
        const auto fill_page = [&](std::uint64_t written) {
            const std::vector<char> zeros(to_pages(written) - written, 0);
            put(zeros.data(), zeros.size());
        };
        const std::uint64_t text_length = text.size();
        put(magic, sizeof(magic));
        put(&version, sizeof(version));
        put(&text_length, sizeof(text_length));
        put(text.data(), text.size());
        fill_page(head_bytes + text_length);
        for_numbers(described.shape_space, [&](const double* values, Eigen::Index count) {
            put(values, sizeof(double) * static_cast<std::size_t>(count));
        });
        fill_page(space_bytes);
        for (std::size_t p = 0; p < described.parts.size(); ++p)
            for (std::size_t i = 0; i < described.parts[p].layers.size(); ++i) {
                const RuntimeLayer& layer = described.parts[p].layers[i];
                std::vector<float> rows(static_cast<std::size_t>(weight_rows) * layer.num_columns), biases(weight_rows);
                std::vector<std::byte> block(weight_block_bytes(layer.storage, layer.num_columns));
                for (int b = 0; b < num_weight_blocks(layer.num_rows); ++b) {
                    std::fill(rows.begin(), rows.end(), 0.0F);
                    std::fill(biases.begin(), biases.end(), 0.0F);
                    source(static_cast<int>(p), static_cast<int>(i), b, rows.data(), biases.data());
                    pack_weight_block(layer.storage, layer.num_columns, rows.data(), biases.data(), block.data());
                    put(block.data(), block.size());
                }
                fill_page(layer_bytes(layer));
            }
    });
}

}  // namespace ndg
