// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/fit_batch.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/log.h"
#include "ndg/dataset/run_batch.h"
#include "ndg/io/mesh.h"
#include "ndg/registration/fit_part.h"
#include "ndg/registration/fit_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

namespace ndg {
namespace {

namespace fs = std::filesystem;

std::string stem(const std::string& file)
{
    return fs::path(file).stem().string();
}

/// The landmarks' file of a scan; empty if there is none.
std::string landmarks_file(const BatchOptions& options, const std::string& name)
{
    if (options.landmarks.empty() || !fs::is_directory(options.landmarks)) return options.landmarks;
    const std::string path = (fs::path(options.landmarks) / (name + ".json")).string();
    return fs::exists(path) ? path : "";
}

/// What the scan's own files hold. One that cannot be read fails where it is fitted, for this scan alone.
std::string content_of(const std::string& file, const std::string& landmarks)
{
    try {
        return sha256_path(file) + (landmarks.empty() ? "" : sha256_path(landmarks));
    } catch (const InputError& error) {
        return error.what();
    }
}

BatchItem batch_item(const std::string& file, const std::string& landmarks)
{
    const std::string name = stem(file), identity = sha256(name + " " + content_of(file, landmarks));
    return {name + "." + identity.substr(0, 16), identity, "scan " + name};
}

/// A scan that cannot be read is its own failure, not the batch's.
FittedBody fit_one(const BodyFitter& fitter, const FitOptions& options, const std::string& file,
                   const std::string& landmarks)
{
    try {
        FittedBody fitted = fitter.fit(stem(file), read_scan(file, options.scan),
                                       landmarks.empty() ? ScanLandmarks{} : read_scan_landmarks(landmarks));
        require(fitted.body.skin_vertices.allFinite() && fitted.posed_skin.allFinite(), "{}: the fit is not finite",
                file);
        log_info("{}", report_line(fitted.report));
        return fitted;
    } catch (const InputError& error) {
        throw Error(error.what());
    }
}

bool is_kept(const BatchEntry& entry, bool keep_failed)
{
    return keep_failed ? entry.failure.empty() : entry.passed();
}

}  // namespace

std::string BatchEntry::name() const
{
    return stem(file);
}

std::vector<std::string> scan_files(const std::vector<std::string>& paths)
{
    std::vector<std::string> files;
    for (const std::string& path : paths) {
        if (!fs::is_directory(path)) {
            files.push_back(path);
            continue;
        }
        std::vector<std::string> inside;
        for (const auto& entry : fs::directory_iterator(path)) {
            if (entry.is_regular_file() && is_mesh_name(entry.path().string())) inside.push_back(entry.path().string());
        }
        require_input(!inside.empty(), "{}: holds no OBJ, PLY, OFF, STL or GLB file", path);
        std::sort(inside.begin(), inside.end());
        files.insert(files.end(), inside.begin(), inside.end());
    }
    std::map<std::string, std::string> by_name;
    for (const std::string& file : files) {
        const auto [other, is_new] = by_name.emplace(stem(file), file);
        require_input(is_new, "{} and {} would both be body \"{}\"", other->second, file, stem(file));
    }
    return files;
}

std::vector<BatchEntry> fit_batch(const BodyFitter& fitter, const std::vector<std::string>& files,
                                  const FitOptions& fit_options, const Eigen::Ref<const Triangles>& triangles,
                                  const BatchOptions& options, const PartStore& store,
                                  const std::function<bool()>& stop)
{
    std::vector<std::string> landmarks;
    Batch batch;
    batch.task = "fitting";
    batch.lone_item_parallel = true;
    for (const std::string& file : files) {
        landmarks.push_back(landmarks_file(options, stem(file)));
        batch.items.push_back(batch_item(file, landmarks.back()));
    }
    batch.read = [](const H5Reader& part) { read_fit(part); };
    batch.make_worker = [&] {
        return [&](int i) -> PartWriter {
            const FittedBody fitted = fit_one(fitter, fit_options, files[i], landmarks[i]);
            return [fitted](H5Writer& part) { write_fit(part, fitted); };
        };
    };
    run_batch(store, batch, stop);

    if (!options.surfaces.empty()) fs::create_directories(options.surfaces);
    std::vector<BatchEntry> entries(files.size());
    for (std::size_t i = 0; i < files.size(); ++i) {
        BatchEntry& entry = entries[i];
        entry.file = files[i];
        entry.failure = store.read(batch.items[i], [&](const H5Reader& part) { entry.fitted = read_fit(part); });
        if (!entry.failure.empty()) continue;
        entry.fitted.report.file = entry.file;
        if (!options.surfaces.empty()) {
            write_mesh((fs::path(options.surfaces) / (entry.name() + ".ply")).string(), entry.fitted.posed_skin,
                       triangles);
        }
    }
    return entries;
}

SkinSet batch_skins(const std::vector<BatchEntry>& entries, bool keep_failed,
                    const std::function<std::pair<double, double>(const std::string&)>& person)
{
    SkinSet skins;
    skins.parameter_names = {"sex", "age_years", "stature_m", "fit_mean_m"};
    for (const BatchEntry& entry : entries) {
        if (is_kept(entry, keep_failed)) skins.bodies.push_back(entry.fitted.body);
    }
    skins.parameters.resize(static_cast<Eigen::Index>(skins.bodies.size()), 4);
    Eigen::Index row = 0;
    for (const BatchEntry& entry : entries) {
        if (!is_kept(entry, keep_failed)) continue;
        const auto [sex, age] = person(entry.fitted.body.name);
        skins.parameters.row(row++) << sex, age, entry.fitted.report.stature, entry.fitted.report.scan_to_skin_mean;
    }
    return skins;
}

PoseSet batch_poses(const std::vector<BatchEntry>& entries, bool keep_failed)
{
    PoseSet poses;
    for (const BatchEntry& entry : entries) {
        if (!is_kept(entry, keep_failed)) continue;
        poses.poses.push_back(entry.fitted.pose);
        poses.clip_idx.push_back(static_cast<int>(poses.clip_names.size()));
        poses.frame_idx.push_back(0);
        poses.clip_names.push_back(entry.fitted.body.name);
        poses.clip_frame_rates.push_back(1.0);
    }
    return poses;
}

}  // namespace ndg
