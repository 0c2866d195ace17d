// SPDX-License-Identifier: Apache-2.0
#include "ndg/release/onnx_network.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"
#include "ndg/release/onnx_file.h"
#include "ndg/runtime/model_layout.h"
#include "ndg/runtime/model_traits.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

using Shape = OnnxGraph::Shape;

constexpr float layer_norm_epsilon = 1e-5F;          // torch's, too
constexpr int taylor_degree = 8, num_squarings = 6;  // exp: |Q| <= 32 becomes at most 1/2

class NetworkGraph {
public:
    NetworkGraph(const H5Reader& file, const OnnxOptions& options)
        : file_(file), options_(options), traits_(read_model_traits(file))
    {
        for (const auto& [name, value] :
             {std::pair("zero_point_five", 0.5), std::pair("one", 1.0), std::pair("one_over_sqrt_two", std::sqrt(0.5))})
            graph_.add_constant(name, {}, std::vector<float>{static_cast<float>(value)});
        graph_.add_constant("identity", {3, 3}, std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1});
        graph_.add_constant("flat", {0, -1});  // as shapes: the batch as it is, the rest in one
        graph_.add_constant("matrices", {0, -1, 3, 3});
        graph_.add_constant("points", {0, -1, 3});
        add_activation(add_network(add_features()));
    }

    const OnnxGraph& graph() const { return graph_; }

private:
    std::string add_features()
    {
        const std::vector<int> visible = file_.read_ints("/input/visible_joints", -1, 0, 1);
        const auto num_joints = static_cast<std::int64_t>(visible.size());
        graph_.add_input("parent_from_joint", {-1, num_joints, 3, 3}, "rotations of the pose, relative to rest");
        graph_.add_constant("visible_joints", {1, num_joints, 1, 1},
                            std::vector<float>(visible.begin(), visible.end()));
        const std::string turned = graph_.add("Sub", {"parent_from_joint", "identity"});
        const std::string pose = graph_.add("Reshape", {graph_.add("Mul", {turned, "visible_joints"}), "flat"});
        if (!traits_.shape) return pose;
        const ShapeSpace space = read_model_shape_space(file_, -1);
        graph_.add_input("shape_code", {-1, space.dimension()}, "code of the body's rest shape, m");
        graph_.add_constant("code_scale", {}, std::vector<float>{static_cast<float>(shape_code_scale(space))});
        return graph_.add("Concat", {pose, graph_.add("Div", {"shape_code", "code_scale"})}, {{"axis", 1}});
    }

    /// Rows begin to end of a matrix, as a constant.
    std::string add_rows(const std::string& dataset, std::int64_t columns, int begin, int end, bool whole)
    {
        const std::string name = whole ? dataset.substr(1) : fmt::format("{}_{}", dataset.substr(1), begin);
        const H5Reader& file = file_;
        return graph_.add_constant(name, {end - begin, columns}, [&file, dataset, begin, end](std::ostream& stream) {
            for (int row = begin; row < end; ++row) {
                const std::vector<float> values = file.read_slice(dataset, static_cast<std::size_t>(row));
                stream.write(reinterpret_cast<const char*>(values.data()),
                             static_cast<std::streamsize>(sizeof(float) * values.size()));
            }
        });
    }
    int rows_of_constant(int columns) const
    {
        return std::max(1, static_cast<int>(1e6 * options_.max_constant_mb / sizeof(float) / columns));
    }
    std::string add_vector(const std::string& dataset, int begin, int end, bool whole)
    {
        const std::vector<double> values = file_.read_doubles(dataset);
        const std::string name = whole ? dataset.substr(1) : fmt::format("{}_{}", dataset.substr(1), begin);
        return graph_.add_constant(name, {end - begin},
                                   std::vector<float>(values.begin() + begin, values.begin() + end));
    }

    /// The linear part of a layer: by blocks of rows, which follow each other in the result.
    std::string add_linear(const LayerLayout& layer, const std::string& input)
    {
        std::vector<std::string> blocks;
        const int step = rows_of_constant(layer.num_columns);
        const bool whole = step >= layer.num_rows;
        for (int begin = 0; begin < layer.num_rows; begin += step) {
            const int end = std::min(layer.num_rows, begin + step);
            const std::string weight = add_rows(layer.group + "/weight", layer.num_columns, begin, end, whole);
            const std::string bias = add_vector(layer.group + "/bias", begin, end, whole);
            blocks.push_back(graph_.add("Gemm", {input, weight, bias}, {{"transB", 1}}));
        }
        return whole ? blocks.front() : graph_.add("Concat", blocks, {{"axis", 1}});
    }

    /// A fixed map behind the last layer: by blocks of its rows, whose results are added.
    std::string add_basis(const PartLayout& part, const std::string& coefficients)
    {
        const int rows = part.layers.back().num_rows, step = rows_of_constant(part.num_outputs);
        if (step >= rows)
            return graph_.add("MatMul", {coefficients, add_rows(part.basis, part.num_outputs, 0, rows, true)});
        std::string sum;
        const std::string axis = graph_.add_constant(part.basis.substr(1) + "_axis", {1});
        for (int begin = 0; begin < rows; begin += step) {
            const int end = std::min(rows, begin + step);
            const std::string block = add_rows(part.basis, part.num_outputs, begin, end, false);
            const std::string low = graph_.add_constant(block + "_begin", {begin});
            const std::string high = graph_.add_constant(block + "_end", {end});
            const std::string product =
                graph_.add("MatMul", {graph_.add("Slice", {coefficients, low, high, axis}), block});
            sum = sum.empty() ? product : graph_.add("Add", {sum, product});
        }
        return sum;
    }

    std::string add_part(const PartLayout& part, std::string x)
    {
        if (!part.region.empty()) x = graph_.add("Gather", {x, add_columns(part.region + "/inputs")}, {{"axis", 1}});
        for (const LayerLayout& layer : part.layers) {
            x = add_linear(layer, x);
            if (!layer.has_norm) continue;
            const int rows = layer.num_rows;
            x = graph_.add("LayerNormalization",
                           {x, add_vector(layer.group + "/norm_weight", 0, rows, true),
                            add_vector(layer.group + "/norm_bias", 0, rows, true)},
                           {{"axis", -1}, {"epsilon", 0, layer_norm_epsilon, true}});
            // GELU, x (1 + erf(x / sqrt 2)) / 2: no operator of its own before opset 20.
            const std::string erf = graph_.add("Erf", {graph_.add("Mul", {x, "one_over_sqrt_two"})});
            x = graph_.add("Mul", {graph_.add("Mul", {x, graph_.add("Add", {erf, "one"})}), "zero_point_five"});
        }
        return part.basis.empty() ? x : add_basis(part, x);
    }

    std::string add_columns(const std::string& dataset)
    {
        const std::vector<int> columns = file_.read_ints(dataset, -1, 0, 1 << 30);
        return graph_.add_constant(dataset.substr(1), std::vector<std::int64_t>(columns.begin(), columns.end()));
    }

    std::string add_network(const std::string& features)
    {
        const std::vector<PartLayout> parts = read_model_layout(file_);
        std::vector<std::string> results;
        std::vector<std::int64_t> columns;  // of the raw outputs, region after region
        for (const PartLayout& part : parts) {
            results.push_back(add_part(part, features));
            num_outputs_ += part.num_outputs;
            if (part.region.empty()) continue;
            const std::vector<int> outputs = file_.read_ints(part.region + "/outputs", part.num_outputs, 0, 1 << 30);
            columns.insert(columns.end(), outputs.begin(), outputs.end());
        }
        if (columns.empty()) return graph_.add("Identity", {results.front()}, {}, "outputs");
        std::vector<std::int64_t> places(columns.size(), -1);
        for (std::size_t i = 0; i < columns.size(); ++i) {
            require_input(columns[i] < num_outputs_ && places[columns[i]] < 0,
                          "{}: output {} of the network is given twice or does not exist", file_.path(), columns[i]);
            places[columns[i]] = static_cast<std::int64_t>(i);
        }
        graph_.add_constant("places", places);
        return graph_.add("Gather", {graph_.add("Concat", results, {{"axis", 1}}), "places"}, {{"axis", 1}}, "outputs");
    }

    void add_activation(const std::string& outputs)
    {
        graph_.add_output("outputs", {-1, num_outputs_}, "what the last layer gives");
        if (traits_.output_space == "vertex-offsets") {
            graph_.add_constant("metres_of_mm", {}, std::vector<float>{0.001F});
            graph_.add("Mul", {graph_.add("Reshape", {outputs, "points"}), "metres_of_mm"}, {}, "offsets");
            graph_.add_output("offsets", {-1, num_outputs_ / 3, 3}, "of muscle wrap and skin in the rest pose, m");
        }
        const bool direct = traits_.parametrisation == ParametrisationKind::direct;
        if (traits_.output_space != "residuals" ||
            (!direct && traits_.parametrisation != ParametrisationKind::exponential))
            return;
        graph_.add_output("residuals", {-1, num_outputs_ / 9, 3, 3},
                          traits_.rotation ? "residual deformation gradients R_p^T F_p of the prisms"
                                           : "deformation gradients F_p of the prisms in the root's frame");
        const std::string q = graph_.add("Reshape", {outputs, "matrices"});
        if (direct) {
            graph_.add("Add", {q, "identity"}, {}, "residuals");
            return;
        }
        graph_.add_constant("scale", {}, std::vector<float>{std::ldexp(1.0F, -num_squarings)});
        const std::string a = graph_.add("Mul", {q, "scale"});
        // exp(a) - I, which keeps the digits that I + a would lose. Horner: a (I + a / 2 (I + a / 3 (...))).
        std::string series = "identity";
        for (int k = taylor_degree; k >= 1; --k) {
            const std::string term = k == taylor_degree ? a : graph_.add("MatMul", {a, series});
            if (k == 1) {
                series = term;
                break;
            }
            const std::string over_k =
                graph_.add_constant(fmt::format("one_over_{}", k), {}, std::vector<float>{1.0F / float(k)});
            series = graph_.add("Add", {graph_.add("Mul", {term, over_k}), "identity"});
        }
        graph_.add_constant("two", {}, std::vector<float>{2});
        for (int i = 0; i < num_squarings; ++i)  // (I + x)^2 - I = 2 x + x^2
            series = graph_.add("Add", {graph_.add("Mul", {series, "two"}), graph_.add("MatMul", {series, series})});
        graph_.add("Add", {series, "identity"}, {}, "residuals");
    }

    const H5Reader& file_;
    OnnxOptions options_;
    ModelTraits traits_;
    OnnxGraph graph_;
    std::int64_t num_outputs_ = 0;
};

}  // namespace

void describe(OptionList& list, OnnxOptions& options)
{
    list.add("max-constant-mb", options.max_constant_mb, "ONNX: larger matrices are split into several constants", 1e-4,
             2000);
}

void write_onnx(const std::string& path, const std::string& model_path, const OnnxOptions& options)
{
    check_options(options);
    const H5Reader file(model_path, model_format, model_version);
    const NetworkGraph network(file, options);
    network.graph().write(path, "Neural deformation gradients: a network that sees pose and body shape",
                          {{"template_sha256", file.attribute("template_sha256")},
                           {"inputs", file.attribute("inputs")},
                           {"licences", file.attribute("licences")}});
}

}  // namespace ndg
