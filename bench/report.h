// SPDX-License-Identifier: Apache-2.0
// What a benchmark measured: a table, one JSON line, and a JSON file.
#pragma once

#include "ndg/core/error.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace ndg::bench {

/// Quantile of unsorted values by linear interpolation; `share` in [0, 1].
inline double quantile(std::vector<double> values, double share)
{
    require(!values.empty(), "nothing was measured");
    std::sort(values.begin(), values.end());
    const double place = share * static_cast<double>(values.size() - 1);
    const auto low = static_cast<std::size_t>(place);
    const std::size_t high = std::min(low + 1, values.size() - 1);
    return values[low] + (place - static_cast<double>(low)) * (values[high] - values[low]);
}

/// Processor name and number of hardware threads.
inline std::string machine_name()
{
    std::ifstream file("/proc/cpuinfo");
    std::string name = "unknown processor";
    for (std::string line; std::getline(file, line);) {
        const auto colon = line.find(": ");
        if (line.rfind("model name", 0) == 0 && colon != std::string::npos) {
            name = line.substr(colon + 2);
            break;
        }
    }
    return fmt::format("{}, {} threads", name, std::thread::hardware_concurrency());
}

class Report {
public:
    explicit Report(std::string name) : name_(std::move(name)) {}

    void add(const std::string& metric, double value) { metrics_.emplace_back(metric, value); }

    void print() const
    {
        for (const auto& [metric, value] : metrics_) fmt::print("{:<28} {:.6g}\n", metric, value);
        fmt::print("{}\n", json());
    }

    void write(const std::string& path) const
    {
        std::ofstream file(path);
        file << json() << "\n";
        file.close();
        require_input(!file.fail(), "{}: the result could not be written", path);
    }

    std::string json() const
    {
        std::string metrics;
        for (const auto& [metric, value] : metrics_) {
            require(std::isfinite(value), "{} is {}", metric, value);
            metrics += fmt::format("{}\"{}\": {}", metrics.empty() ? "" : ", ", metric, value);
        }
        return fmt::format("{{\"name\": \"{}\", \"machine\": \"{}\", \"metrics\": {{{}}}}}", name_, machine_name(),
                           metrics);
    }

private:
    std::string name_;
    std::vector<std::pair<std::string, double>> metrics_;
};

}  // namespace ndg::bench
