// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/fit_batch.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/log.h"
#include "ndg/io/mesh.h"
#include "ndg/registration/fit_part.h"
#include "ndg/registration/fit_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>

namespace ndg {
namespace {

namespace fs = std::filesystem;

std::string parts_folder(const BatchOptions& options)
{
    return options.output + ".parts";
}

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

/// Depends on everything that the fit depends on.
std::string part_file(const BatchOptions& options, const std::string& file, const std::string& landmarks)
{
    std::string key = options.settings + sha256_path(file);
    if (!landmarks.empty()) key += sha256_path(landmarks);
    return (fs::path(parts_folder(options)) / (stem(file) + "." + sha256(key).substr(0, 16) + ".h5")).string();
}

std::optional<FittedBody> finished_part(const std::string& path)
{
    if (!fs::exists(path)) return std::nullopt;
    try {
        return read_fit_part(path);
    } catch (const Error& error) {
        log_warning("{} is made anew: {}", path, error.what());
        return std::nullopt;
    }
}

void fit_one(const BodyFitter& fitter, const FitOptions& fit_options, const Eigen::Ref<const Triangles>& triangles,
             const BatchOptions& options, BatchEntry& entry)
{
    const std::string name = stem(entry.file), landmarks = landmarks_file(options, name);
    const std::string part = part_file(options, entry.file, landmarks);
    if (std::optional<FittedBody> finished = finished_part(part)) {
        entry.fitted = std::move(*finished);
        log_info("{}: fitted by an earlier run", name);
    } else {
        const ScanPoints scan = read_scan(entry.file, fit_options.scan);
        entry.fitted = fitter.fit(name, scan, landmarks.empty() ? ScanLandmarks{} : read_scan_landmarks(landmarks));
        entry.fitted.report.file = entry.file;
        write_fit_part(part, entry.fitted);
    }
    if (!options.surfaces.empty()) {
        write_mesh((fs::path(options.surfaces) / (name + ".ply")).string(), entry.fitted.posed_skin, triangles);
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
                                  const BatchOptions& options, const std::function<bool()>& stop)
{
    fs::create_directories(parts_folder(options));
    if (!options.surfaces.empty()) fs::create_directories(options.surfaces);
    std::vector<BatchEntry> entries(files.size());
    std::atomic<bool> stopped{false};
    std::exception_ptr fatal;
    // Several scans: one thread each. A single one is parallel inside.
#pragma omp parallel for schedule(dynamic, 1) if (files.size() > 1)
    for (std::size_t i = 0; i < files.size(); ++i) {
        if (stopped || stop()) {
            stopped = true;
            continue;
        }
        BatchEntry& entry = entries[i];
        entry.file = files[i];
        try {
            fit_one(fitter, fit_options, triangles, options, entry);
        } catch (const Error& error) {
            entry.failure = error.what();
        } catch (...) {
#pragma omp critical(fit_batch_report)
            fatal = std::current_exception();
            stopped = true;
            continue;
        }
#pragma omp critical(fit_batch_report)
        log_info("{}", entry.failure.empty() ? report_line(entry.fitted.report) : "FAILED: " + entry.failure);
    }
    if (fatal) std::rethrow_exception(fatal);
    if (stopped) {
        throw Interrupted(fmt::format("interrupted; finished scans are kept in {}, the same command goes on from there",
                                      parts_folder(options)));
    }
    return entries;
}

void remove_parts(const BatchOptions& options)
{
    std::error_code error;
    fs::remove_all(parts_folder(options), error);
    if (error) log_warning("{} could not be removed: {}", parts_folder(options), error.message());
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
