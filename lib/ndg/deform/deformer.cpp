// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/deformer.h"

#include "ndg/core/error.h"

namespace ndg {

Points Deformer::anatomy(const PosedBody& posed, const Eigen::Ref<const Points>& anatomy_rest,
                         const Eigen::Ref<const Points>& vertices)
{
    return posed.anatomy(anatomy_rest, vertices);
}

std::vector<Points> Deformer::deform_batch(const std::vector<PosedBody>& posed)
{
    std::vector<Points> vertices;
    for (const PosedBody& one : posed) vertices.push_back(deform(one));
    return vertices;
}

void MethodTable::add(DeformationMethod method)
{
    require(!method.flag.empty() && !method.table_name.empty() && !method.summary.empty(),
            "method \"{}\" ({}) lacks a name or summary", method.flag, method.table_name);
    for (const DeformationMethod& other : methods_) {
        require(method.flag != other.flag && method.table_name != other.table_name,
                "method \"{}\" ({}) is in the table already", method.flag, method.table_name);
    }
    methods_.push_back(std::move(method));
}

const DeformationMethod& MethodTable::find(const std::string& flag) const
{
    for (const DeformationMethod& method : methods_) {
        if (method.flag == flag) return method;
    }
    throw InputError(fmt::format("unknown method \"{}\"; known are {}", flag, fmt::join(flags(), ", ")));
}

std::vector<std::string> MethodTable::flags() const
{
    std::vector<std::string> flags;
    for (const DeformationMethod& method : methods_) flags.push_back(method.flag);
    return flags;
}

std::string MethodTable::help() const
{
    std::string text;
    for (const DeformationMethod& method : methods_) {
        text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", method.flag, method.summary);
    }
    return text;
}

void MethodTable::add_options(Tool& tool) const
{
    for (const DeformationMethod& method : methods_) {
        if (method.add_options) method.add_options(tool);
    }
}

}  // namespace ndg
