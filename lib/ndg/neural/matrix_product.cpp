// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/matrix_product.h"

#include "ndg/core/error.h"

#ifdef NDG_WITH_DNNL
#include <omp.h>
#include <oneapi/dnnl/dnnl.hpp>

#include <array>
#include <map>
#endif

namespace ndg {

#ifdef NDG_WITH_DNNL
namespace {

const dnnl::engine& processor()
{
    static const dnnl::engine engine(dnnl::engine::kind::cpu, 0);
    return engine;
}

dnnl::memory::desc describe_matrix(const torch::Tensor& matrix)
{
    const auto type =
        matrix.scalar_type() == torch::kBFloat16 ? dnnl::memory::data_type::bf16 : dnnl::memory::data_type::f32;
    return {{matrix.size(0), matrix.size(1)}, type, {matrix.stride(0), matrix.stride(1)}};
}

/// A product of certain shapes, ready to run: making one takes longer than a small product.
struct Prepared {
    dnnl::matmul primitive;
    dnnl::memory a, b, result, scratchpad;

    Prepared(const torch::Tensor& left, const torch::Tensor& right, Into into)
    {
        dnnl::primitive_attr attributes;
        attributes.set_scratchpad_mode(dnnl::scratchpad_mode::user);  // oneDNN's own is one for all threads
        if (into == Into::add) {
            dnnl::post_ops added;
            added.append_sum(1.0f);
            attributes.set_post_ops(added);
        }
        const dnnl::memory::desc a_shape = describe_matrix(left), b_shape = describe_matrix(right);
        const dnnl::memory::desc result_shape({left.size(0), right.size(1)}, dnnl::memory::data_type::f32,
                                              {right.size(1), 1});
        const dnnl::matmul::primitive_desc description(dnnl::matmul::desc(a_shape, b_shape, result_shape), attributes,
                                                       processor());
        primitive = dnnl::matmul(description);
        a = dnnl::memory(a_shape, processor(), nullptr);
        b = dnnl::memory(b_shape, processor(), nullptr);
        result = dnnl::memory(result_shape, processor(), nullptr);
        scratchpad = dnnl::memory(description.scratchpad_desc(), processor());
    }
};

Prepared& prepare(const torch::Tensor& a, const torch::Tensor& b, Into into)
{
    const std::int64_t threads = omp_in_parallel() ? 1 : omp_get_max_threads();
    const std::array<std::int64_t, 10> key = {static_cast<std::int64_t>(a.scalar_type()),
                                              threads,
                                              static_cast<std::int64_t>(into),
                                              a.size(0),
                                              a.size(1),
                                              b.size(1),
                                              a.stride(0),
                                              a.stride(1),
                                              b.stride(0),
                                              b.stride(1)};
    thread_local std::map<std::array<std::int64_t, 10>, Prepared> all;
    constexpr std::size_t most = 64;  // a network has a few shapes
    const auto found = all.find(key);
    if (found != all.end()) return found->second;
    if (all.size() == most) all.clear();
    return all.try_emplace(key, a, b, into).first->second;
}

void run(const torch::Tensor& a, const torch::Tensor& b, float* result, Into into)
{
    Prepared& prepared = prepare(a, b, into);
    prepared.a.set_data_handle(a.data_ptr());
    prepared.b.set_data_handle(b.data_ptr());
    prepared.result.set_data_handle(result);
    dnnl::stream stream(processor());
    prepared.primitive.execute(stream, {{DNNL_ARG_SRC, prepared.a},
                                        {DNNL_ARG_WEIGHTS, prepared.b},
                                        {DNNL_ARG_DST, prepared.result},
                                        {DNNL_ARG_SCRATCHPAD, prepared.scratchpad}});
    stream.wait();
}

}  // namespace
#else
namespace {

void run(const torch::Tensor& a, const torch::Tensor& b, float* result, Into into)
{
    torch::Tensor sums = torch::from_blob(result, {a.size(0), b.size(1)}, torch::kFloat32);
    if (a.scalar_type() == torch::kFloat32)
        sums.addmm_(a, b, into == Into::add ? 1 : 0);
    else if (into == Into::add)
        sums.add_(torch::mm(a, b));
    else
        sums.copy_(torch::mm(a, b));
}

}  // namespace
#endif

void product(const torch::Tensor& a, const torch::Tensor& b, float* result, Into into)
{
    require(a.size(1) == b.size(0) && a.scalar_type() == b.scalar_type(),
            "A matrix of {} x {} was to be multiplied by one of {} x {}", a.size(0), a.size(1), b.size(0), b.size(1));
    const torch::NoGradGuard no_grad;
    run(a, b, result, into);
}

torch::Tensor product(const torch::Tensor& a, const torch::Tensor& b)
{
    const torch::NoGradGuard no_grad;
    if (!a.device().is_cpu()) return torch::mm(a, b).to(torch::kFloat32);
    torch::Tensor result = torch::empty({a.size(0), b.size(1)}, torch::kFloat32);
    product(a, b, result.data_ptr<float>());
    return result;
}

}  // namespace ndg
