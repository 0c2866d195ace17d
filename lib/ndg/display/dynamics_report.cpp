// SPDX-License-Identifier: Apache-2.0
#include "ndg/display/dynamics_report.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/json_file.h"
#include "ndg/core/markup.h"
#include "ndg/display/dynamics_display.h"
#include "ndg/display/penetrations.h"
#include "ndg/display/sequence_picture.h"
#include "ndg/evaluate/report_html.h"

#include <algorithm>
#include <filesystem>
#include <numeric>

namespace ndg {

namespace {

using Table = std::vector<std::vector<std::string>>;

std::string millimetres(double metres)
{
    return fmt::format("{:.{}f}", 1e3 * metres, metres < 1e-4 ? 6 : 2);
}

DynamicsFigures figures_of(const DynamicsDisplay& display)
{
    DynamicsFigures result;
    const auto [begin, end] = display.set().frames_of(0);
    const auto count = static_cast<double>(std::count(display.soft().begin(), display.soft().end(), char(1)));
    for (int frame = begin; frame < end; ++frame) {
        Eigen::VectorXd distances = display.displacements(frame);
        for (Eigen::Index v = 0; v < distances.size(); ++v) {
            if (display.soft()[static_cast<std::size_t>(v)] == 0) distances[v] = 0;
        }
        result.largest_metre = distances.maxCoeff();
        result.mean_metre = distances.sum() / count;
        result.largest_ever_metre = std::max(result.largest_ever_metre, result.largest_metre);
    }
    return result;
}

std::vector<std::string> row_of(const DynamicsFigureRun& run, const DynamicsDisplay& display)
{
    const DynamicsSet& set = display.set();
    const auto sum = [&](const char* name) {
        const std::vector<double>& values = set.statistics.at(name);
        return std::accumulate(values.begin(), values.end(), 0.0);
    };
    const DynamicsFigures figures = figures_of(display);
    const double frames = set.num_frames();
    const double steps = std::max(1.0, (frames - 1) / (set.time_step_seconds * set.frame_rate_hertz));
    return {run.label,
            fmt::format("{:.2f}", set.times.back()),
            fmt::format("{:.1f}", 100 * sum("converged") / frames),
            fmt::format("{:.3f}", sum("seconds") / steps),
            millimetres(figures.largest_metre),
            millimetres(figures.mean_metre),
            millimetres(figures.largest_ever_metre)};
}

/// The last frames of several runs as frames of one sequence. Keeps references.
MeshSequence last_frames(const std::vector<DynamicsDisplay>& displays, double range)
{
    MeshSequence sequence = displays[0].sequence(0, "", range);
    sequence.meshes.resize(1);
    sequence.num_frames = static_cast<int>(displays.size());
    sequence.frame = [&displays, range](int k) {
        const DynamicsDisplay& display = displays[static_cast<std::size_t>(k)];
        const int last = display.set().frames_of(0).second - 1;
        MeshFrame frame;
        frame.vertices = display.skin(last, display.reader().frame(last));
        frame.colours = distance_colours(display.displacements(last), range);
        return std::vector<MeshFrame>{frame};
    };
    return sequence;
}

std::string commands_of(const DynamicsFigure& figure)
{
    std::string text;
    for (const DynamicsFigureRun& run : figure.runs) {
        const std::filesystem::path path = std::filesystem::path(run.path).replace_extension(".txt");
        if (std::filesystem::exists(path)) text += escaped_markup(run.label + ": " + read_file(path.string()));
    }
    return text.empty() ? "" : "<details><summary>Commands</summary><pre class=\"wide\">" + text + "</pre></details>\n";
}

Table penetration_table(const std::vector<PenetrationCount>& counts)
{
    Table table{{"what", "inside what", "skin there", "frames", "most vertices", "deepest mm"}};
    for (const PenetrationCount& count : counts) {
        table.push_back({count.inner, count.outer, count.held ? "held" : "gives way", std::to_string(count.frames),
                         std::to_string(count.most_vertices), fmt::format("{:.2f}", 1e3 * count.deepest_metre)});
    }
    return table;
}

DynamicsFigure read_figure(const JsonValue& value, const std::string& folder)
{
    value.check_keys({"title", "note", "kind", "range_mm", "view", "frames", "runs"});
    DynamicsFigure figure;
    figure.title = value.at("title").text();
    figure.note = value.text_or("note", "");
    figure.kind = value.at("kind").choice({"distance", "motion"}) == 0 ? DynamicsFigureKind::distance
                                                                       : DynamicsFigureKind::motion;
    figure.range_metre = 1e-3 * value.number_or("range_mm", 20, 1e-3, 1e4);
    if (value.has("view")) {
        std::vector<std::string> views;
        for (const EnumName<View>& view : enum_table<View>) views.emplace_back(view.name);
        figure.view = enum_table<View>[value.at("view").choice(views)].value;
    }
    if (value.has("frames")) figure.frames = value.at("frames").integer(1, 100);
    for (const JsonValue& run : value.at("runs").elements()) {
        run.check_keys({"label", "name"});
        const std::filesystem::path path = std::filesystem::path(folder) / (run.at("name").text() + ".h5");
        figure.runs.push_back({run.at("label").text(), path.string()});
    }
    value.at("runs").expect(!figure.runs.empty(), "at least one run");
    return figure;
}

}  // namespace

std::vector<DynamicsFigure> read_dynamics_figures(const std::string& path, const std::string& folder)
{
    const JsonValue root(path);
    root.check_keys({"description", "figures"});
    std::vector<DynamicsFigure> figures;
    for (const JsonValue& value : root.at("figures").elements()) figures.push_back(read_figure(value, folder));
    root.at("figures").expect(!figures.empty(), "at least one figure");
    return figures;
}

void write_dynamics_report(const std::string& output, const std::vector<DynamicsFigure>& figures, const Avatar& avatar,
                           int picture_height)
{
    const std::filesystem::path folder = std::filesystem::path(output).parent_path();
    std::string body;
    for (std::size_t i = 0; i < figures.size(); ++i) {
        const DynamicsFigure& figure = figures[i];
        std::vector<DynamicsReader> readers;
        readers.reserve(figure.runs.size());
        for (const DynamicsFigureRun& run : figure.runs) readers.emplace_back(run.path);
        std::vector<DynamicsDisplay> displays;
        for (const DynamicsReader& reader : readers) displays.emplace_back(reader, &avatar);
        body += "<h2>" + escaped_markup(figure.title) + "</h2>\n<p class=\"note\">" + escaped_markup(figure.note) +
                "</p>\n";
        Table table{{"run", "s", "frames converged %", "core-seconds a step", "at the end: largest mm", "mean mm",
                     "ever: largest mm"}};
        for (std::size_t r = 0; r < displays.size(); ++r) table.push_back(row_of(figure.runs[r], displays[r]));
        body += html_table(table);
        int number = 0;
        const auto add_picture = [&](const MeshSequence& sequence, int frames, const std::vector<std::string>& labels,
                                     const std::string& caption) {
            SequencePictureOptions options;
            options.frames = frames;
            options.view = figure.view;
            options.height = picture_height;
            const std::string name = fmt::format("figure-{}-{}.png", i + 1, ++number);
            const std::string path = (folder / name).string();
            write_png(path, sequence_picture(sequence, options, labels));
            body += html_figure(html_picture(read_file(path), name), caption);
        };
        if (figure.kind == DynamicsFigureKind::distance) {
            std::vector<std::string> labels;
            for (const DynamicsFigureRun& run : figure.runs) labels.push_back(run.label);
            add_picture(last_frames(displays, figure.range_metre), static_cast<int>(displays.size()), labels,
                        fmt::format("Distance from the skinned shape at the end: white none, red {:g} mm or more.",
                                    1e3 * figure.range_metre));
        } else {
            for (std::size_t r = 0; r < displays.size(); ++r) {
                add_picture(displays[r].sequence(0, ""), figure.frames, {}, figure.runs[r].label);
                body += html_table(penetration_table(count_penetrations(displays[r], 0)));
            }
        }
        body += commands_of(figure);
    }
    if (!avatar.licences.empty()) {
        body += "<h2>Data</h2>\n<pre class=\"wide\">" + escaped_markup(avatar.licences) + "</pre>\n";
    }
    write_file(output, html_report("Soft tissue in motion: figures of Romero et al. 2020 remade", body));
}

}  // namespace ndg
