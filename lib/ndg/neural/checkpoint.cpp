// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/checkpoint.h"

#include "ndg/core/error.h"
#include "ndg/neural/archive_stream.h"

#include <torch/serialize/input-archive.h>
#include <torch/serialize/output-archive.h>
#include <nlohmann/json.hpp>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <system_error>

namespace ndg {
namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

void copy_tensors(const std::vector<torch::Tensor>& from, std::vector<torch::Tensor>& to)
{
    to.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) {
        if (!to[i].defined()) to[i] = torch::empty(from[i].sizes(), torch::kFloat32);
        to[i].copy_(from[i].detach());
    }
}

Json description(const Checkpoint& c)
{
    return {{"fingerprint", c.fingerprint},
            {"epoch", c.epoch},
            {"batch", c.batch},
            {"loss_sum", c.loss_sum},
            {"neutral_sum", c.neutral_sum},
            {"learning_rate", c.learning_rate},
            {"bad_epochs", c.bad_epochs},
            {"num_steps", c.num_steps},
            {"best_validation_loss", c.best_validation_loss},
            {"curve_epoch", c.curve.epoch},
            {"curve_train", c.curve.train_loss},
            {"curve_validation", c.curve.validation_loss},
            {"initial_train", c.curve.initial_train_loss},
            {"initial_validation", c.curve.initial_validation_loss},
            {"best_epoch", c.curve.best_epoch},
            {"num_parameters", c.parameters.size()},
            {"num_averages", c.averages.size()},
            {"num_best", c.best_parameters.size()},
            {"num_bases", c.bases.size()}};
}

std::string tensor_name(const char* list, std::size_t index)
{
    return fmt::format("{}_{}", list, index);
}

std::vector<torch::Tensor> read_tensors(torch::serialize::InputArchive& archive, const char* list, std::size_t count)
{
    std::vector<torch::Tensor> tensors(count);
    for (std::size_t i = 0; i < count; ++i) archive.read(tensor_name(list, i), tensors[i]);
    return tensors;
}

/// libtorch's allocators have no type of exception that all versions share.
bool is_out_of_memory(const std::exception& error)
{
    if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return true;
    const std::string text = error.what();
    return text.find("can't allocate memory") != std::string::npos ||
           text.find("not enough memory") != std::string::npos || text.find("out of memory") != std::string::npos;
}

}  // namespace

void write_checkpoint(const std::string& path, const Checkpoint& checkpoint)
{
    const std::string temporary = path + ".tmp";
    try {
        torch::serialize::OutputArchive archive;
        archive.write("description", c10::IValue(description(checkpoint).dump()));
        const auto add = [&](const char* list, const std::vector<torch::Tensor>& tensors) {
            for (std::size_t i = 0; i < tensors.size(); ++i)
                archive.write(tensor_name(list, i), tensors[i].detach().cpu());
        };
        add("parameter", checkpoint.parameters);
        add("first_moment", checkpoint.first_moments);
        add("second_moment", checkpoint.second_moments);
        add("average", checkpoint.averages);
        add("best_parameter", checkpoint.best_parameters);
        add("basis", checkpoint.bases);
        std::ofstream file(temporary, std::ios::binary);
        ArchiveBuffer buffer(file);
        std::ostream stream(&buffer);
        archive.save_to(stream);
        file.close();
        if (!file) {
            const std::string reason = std::strerror(errno);
            std::error_code ignored;
            std::filesystem::remove(temporary, ignored);
            throw Error(fmt::format("{}: the checkpoint was not written: {}", temporary, reason));
        }
    } catch (const c10::Error& error) {
        throw Error(fmt::format("{}: the checkpoint was not written: {}", temporary, error.what_without_backtrace()));
    }
    std::error_code failure;
    std::filesystem::rename(temporary, path, failure);
    require(!failure, "{}: the checkpoint was not renamed: {}", path, failure.message());
}

Checkpoint read_checkpoint(const std::string& path)
{
    try {
        torch::serialize::InputArchive archive;
        archive.load_from(path, torch::kCPU);  // also what was written on a GPU that is not here
        c10::IValue text;
        archive.read("description", text);
        const Json json = Json::parse(text.toStringRef());
        Checkpoint c;
        c.fingerprint = json.at("fingerprint").get<std::string>();
        c.epoch = json.at("epoch").get<int>();
        c.batch = json.at("batch").get<int>();
        c.loss_sum = json.at("loss_sum").get<double>();
        c.neutral_sum = json.at("neutral_sum").get<double>();
        c.learning_rate = json.at("learning_rate").get<double>();
        c.bad_epochs = json.at("bad_epochs").get<int>();
        c.num_steps = json.at("num_steps").get<std::int64_t>();
        c.best_validation_loss = json.at("best_validation_loss").get<double>();
        c.curve.epoch = json.at("curve_epoch").get<std::vector<int>>();
        c.curve.train_loss = json.at("curve_train").get<std::vector<double>>();
        c.curve.validation_loss = json.at("curve_validation").get<std::vector<double>>();
        c.curve.initial_train_loss = json.at("initial_train").get<double>();
        c.curve.initial_validation_loss = json.at("initial_validation").get<double>();
        c.curve.best_epoch = json.at("best_epoch").get<int>();
        const auto count = json.at("num_parameters").get<std::size_t>();
        c.parameters = read_tensors(archive, "parameter", count);
        c.first_moments = read_tensors(archive, "first_moment", count);
        c.second_moments = read_tensors(archive, "second_moment", count);
        c.averages = read_tensors(archive, "average", json.at("num_averages").get<std::size_t>());
        c.best_parameters = read_tensors(archive, "best_parameter", json.at("num_best").get<std::size_t>());
        c.bases = read_tensors(archive, "basis", json.at("num_bases").get<std::size_t>());
        return c;
    } catch (const std::exception& error) {
        require(!is_out_of_memory(error), "{}: there is not enough memory to read the training checkpoint", path);
        throw InputError(fmt::format("{}: not a readable training checkpoint; remove it to start afresh", path));
    }
}

CheckpointWriter::~CheckpointWriter()
{
    if (written_.valid()) written_.wait();
}

bool CheckpointWriter::busy()
{
    if (written_.valid() && written_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return true;
    finish();
    return false;
}

void CheckpointWriter::finish()
{
    if (written_.valid()) write_seconds_ = written_.get();
}

void CheckpointWriter::start(const Checkpoint& checkpoint)
{
    finish();
    const Clock::time_point start = Clock::now();
    const torch::NoGradGuard no_grad;
    Checkpoint copy = checkpoint;
    for (auto list :
         {&Checkpoint::parameters, &Checkpoint::first_moments, &Checkpoint::second_moments, &Checkpoint::averages}) {
        copy_tensors(checkpoint.*list, copy_.*list);
        copy.*list = copy_.*list;
    }
    copy_ = std::move(copy);
    copy_seconds_ = seconds_since(start);
    written_ = std::async(std::launch::async, [this] {
        const Clock::time_point begin = Clock::now();
        write_checkpoint(path_, copy_);
        return seconds_since(begin);
    });
}

}  // namespace ndg
