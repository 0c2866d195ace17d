// SPDX-License-Identifier: Apache-2.0
// Networks in other forms than our HDF5 files.
#include "ndg/core/error.h"
#include "ndg/info/describers.h"
#include "ndg/io/motion.h"
#include "ndg/io/zip_file.h"
#include "ndg/runtime/runtime_model.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numeric>

namespace ndg {
namespace {

using nlohmann::json;

/// The entry of an archive whose name, below the folder that torch puts everything in, is this; empty: none.
std::string find_entry(const ZipFile& zip, const std::string& name)
{
    for (const auto& [path, entry] : zip.entries())
        if (path.size() > name.size() &&
            path.compare(path.size() - name.size() - 1, std::string::npos, "/" + name) == 0)
            return path;
    return "";
}

/// All entries with their checksums.
void check_entries(const ZipFile& zip)
{
    for (const auto& [name, entry] : zip.entries()) zip.unpack(name, fmt::format("{}: \"{}\"", zip.path(), name));
}

std::string licences_of(const json& head)
{
    const auto text = head.value("licences", std::string());
    return text.empty() ? "of no data but the project's own" : text;
}

void describe_torchscript(const FileQuestion& file, const json& metadata, FileReport& report)
{
    report.add("what", "a trained network as TorchScript: torch.jit.load(\"{}\")(parent_from_joint, rest_volume)",
               file.path);
    report.add("method", "{} ({}, {}), hidden layers {}", metadata.at("method").get<std::string>(),
               metadata.at("output_space").get<std::string>(), metadata.at("parametrisation").get<std::string>(),
               fmt::join(metadata.at("widths").get<std::vector<int>>(), ", "));
    report.add("sees", "rotations of {} joints (B x {} x 3 x 3) and bodies at rest (B x {} x 3, m)",
               metadata.at("joint_names").size(), metadata.at("joint_names").size(),
               metadata.at("num_volume_vertices").get<int>());
    report.add("training", "epoch {}, validation loss {}", metadata.at("best_epoch").get<int>(),
               metadata.at("validation_loss").dump());
    report.add("template", metadata.at("template_sha256").get<std::string>());
    report.add("written by", "version and commit {}", metadata.at("created_by").get<std::string>());
    std::string inputs;
    for (const json& input : metadata.at("inputs"))
        inputs += fmt::format("{} (sha256 {}...)\n", input.at("path").get<std::string>(),
                              input.at("sha256").get<std::string>().substr(0, 12));
    report.add("made of", inputs);
    report.add("licences", licences_of(metadata));
}

/// Of the state of a training its description, a text among pickled numbers: four bytes of length, then JSON.
void describe_checkpoint(const FileQuestion& file, const std::string& pickled, FileReport& report)
{
    const std::size_t begin = pickled.find("{\"");
    require_input(begin != std::string::npos && begin >= 4 && pickled.find("\"fingerprint\"") != std::string::npos,
                  "{}: is an archive of torch, but neither a network nor a training of ours", file.path);
    const json state = json::parse(pickled.substr(begin, number_at(pickled, begin - 4, 4)), nullptr, false);
    require_input(state.is_object(), "{}: its description is damaged", file.path);
    report.add("what", "the state of a training that is under way or was interrupted: the same train-ndg goes on");
    report.add("training", "epoch {}, batch {}, {} steps, learning rate {:.4g}", state.at("epoch").get<int>(),
               state.at("batch").get<int>(), state.at("num_steps").get<long>(),
               state.at("learning_rate").get<double>());
    report.add("best so far", "validation loss {:.6g}", state.at("best_validation_loss").get<double>());
    report.add("tensors", "{} of the network, {} of its best epoch", state.at("num_parameters").get<int>(),
               state.at("num_best").get<int>());
}

}  // namespace

void describe_zip(const FileQuestion& file, FileReport& report)
{
    const ZipFile zip(file.path);
    try {
        if (const std::string metadata = find_entry(zip, "extra/metadata.json"); !metadata.empty()) {
            describe_torchscript(file, json::parse(zip.unpack(metadata, file.path)), report);
        } else if (const std::string data = find_entry(zip, "data.pkl"); !data.empty()) {
            describe_checkpoint(file, zip.unpack(data, file.path), report);
        } else {
            return describe_motion(file, report);
        }
    } catch (const json::exception& error) {
        throw InputError(fmt::format("{}: its description is damaged ({})", file.path, error.what()));
    }
    report.add("entries", "{}", zip.entries().size());
    if (!file.check) return;
    check_entries(zip);
    report.add("check", "complete, all checksums hold");
}

void describe_safetensors(const FileQuestion& file, FileReport& report)
{
    std::uint64_t length = 0;
    const std::uintmax_t size = std::filesystem::file_size(file.path);
    require_input(file.head.size() >= sizeof(length), "{}: is cut off", file.path);
    std::memcpy(&length, file.head.data(), sizeof(length));
    require_input(length <= size - sizeof(length), "{}: is no safetensors file, or is cut off", file.path);
    std::string text(length, '\0');
    std::ifstream stream(file.path, std::ios::binary);
    stream.seekg(sizeof(length));
    stream.read(text.data(), static_cast<std::streamsize>(length));
    json header = json::parse(text, nullptr, false);
    require_input(header.is_object(), "{}: its header is damaged", file.path);
    const json metadata = header.value("__metadata__", json::object());
    header.erase("__metadata__");
    std::uint64_t end = 0, numbers = 0;
    std::string tensors;
    try {
        for (const auto& [name, tensor] : header.items()) {
            const auto shape = tensor.at("shape").get<std::vector<std::uint64_t>>();
            end = std::max(end, tensor.at("data_offsets").at(1).get<std::uint64_t>());
            numbers += std::accumulate(shape.begin(), shape.end(), std::uint64_t(1), std::multiplies<>());
            tensors +=
                fmt::format("  {:<40} {}  {}\n", name, tensor.at("dtype").get<std::string>(), fmt::join(shape, " x "));
        }
    } catch (const json::exception& error) {
        throw InputError(fmt::format("{}: its header is damaged ({})", file.path, error.what()));
    }
    require_input(sizeof(length) + length + end == size, "{}: has {} bytes, its header says {}", file.path, size,
                  sizeof(length) + length + end);
    report.add("what", "tensors by name, safetensors");
    report.add("numbers", "{} in {} tensors", numbers, header.size());
    const auto text_of = [&](const char* key) { return metadata.value(key, std::string()); };
    if (!text_of("created_by").empty())
        add_provenance(file, text_of("created_by"), text_of("config"), text_of("inputs"), text_of("licences"), report);
    report.add_block("tensors\n" + tensors);
}

void describe_onnx(const FileQuestion& file, FileReport& report)
{
    const bool ours = file.head.find("neural-deformation-gradients") != std::string::npos;
    report.add("what", "a network as a graph of ONNX, {}; what it sees and gives stands in docs/release.md",
               ours ? "by export-release" : "of another program");
    report.add("size", "{:.1f} MB", 1e-6 * double(std::filesystem::file_size(file.path)));
}

void describe_runtime_model(const FileQuestion& file, FileReport& report)
{
    const RuntimeModel model(file.path);
    const json head = json::parse(model.head());
    const RuntimePart& part = model.parts.front();
    report.add("what", "a trained network as libndg maps it into memory (docs/runtime.md)");
    report.add("predicts", "{} of {} prisms ({}), bone wrap {}",
               model.traits.rotation ? "residual deformation gradients" : "deformation gradients", model.num_prisms(),
               to_name(model.traits.parametrisation), to_name(model.traits.posing.bone_wrap));
    report.add("sees", "rotations of {} joints, {} of which move flesh{}", model.joint_names.size(),
               std::count(model.visible_joints.begin(), model.visible_joints.end(), 1),
               model.traits.shape ? fmt::format(", {} numbers of the body", model.shape_space.dimension()) : "");
    std::vector<std::string> layers;
    for (const RuntimeLayer& layer : part.layers)
        layers.push_back(fmt::format("{} x {} {}", layer.num_rows, layer.num_columns, to_name(layer.storage)));
    report.add("network", "{} weights in {:.1f} MB; {}: {}", model.num_weights(), 1e-6 * double(model.weight_bytes()),
               model.parts.size() == 1 ? "layers" : fmt::format("{} parts, the first one's layers", model.parts.size()),
               fmt::join(layers, ", "));
    report.add("template", model.template_sha256);
    add_provenance(file, head.at("created_by").dump(), head.at("config").dump(), head.at("inputs").dump(),
                   head.value("licences", std::string()), report);
    if (!file.check) return;
    model.check_weights();
    report.add("check", "complete and finite");
}

}  // namespace ndg
