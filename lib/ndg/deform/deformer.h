// SPDX-License-Identifier: Apache-2.0
// Ways to pose the flesh, and the table that lists them. A method is a Deformer and a function that adds its row;
// tools/animate.cpp puts the rows together.
#pragma once

#include "ndg/core/tool.h"
#include "ndg/deform/posed_body.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// Gives a posed body its flesh. May keep what the last body's rest shape costs, so bodies in turn are cheapest. To be
/// called from one thread at a time.
class Deformer {
public:
    virtual ~Deformer() = default;

    /// Deformed volume vertices, N_v x 3; the first N_w rows are the bone wrap.
    virtual Points deform(const PosedBody& posed) = 0;
    /// The posed body's anatomy, N_a x 3, with the `vertices` that deform() gave. Carried by the volume
    /// (PosedBody::anatomy), unless the method moves bones and muscles in a way of its own. `anatomy_rest`:
    /// anatomy_at_rest of the body.
    virtual Points anatomy(const PosedBody& posed, const Eigen::Ref<const Points>& anatomy_rest,
                           const Eigen::Ref<const Points>& vertices);
    /// Several at once, for methods that are faster that way.
    virtual std::vector<Points> deform_batch(const std::vector<PosedBody>& posed);
    /// How many at once are best.
    virtual int batch_size() const { return 1; }
    /// Name in tables, where it is not the one of the method's row: what a file says of itself.
    virtual std::string name() const { return ""; }
};

/// One row of the table of methods.
struct DeformationMethod {
    std::string flag;        ///< of --method and, in the pipeline, the name of the method's files: "gradient-skinning"
    std::string table_name;  ///< in result tables: "Gradient Skinning"
    std::string summary;     ///< a few words
    /// Adds what the method needs beside bodies and poses to a tool, none of it required; empty where it needs nothing.
    /// Methods that share options let the first of them add these.
    std::function<void(Tool&)> add_options;
    /// Inside Tool::run; `poser` poses the bodies it will deform. Keeps a reference to the template. Throws InputError
    /// naming an option that is missing or does not fit.
    std::function<std::unique_ptr<Deformer>(const BodyPoser& poser)> make;
};

/// The methods a program knows, in the order of result tables.
class MethodTable {
public:
    /// Throws Error for an empty name or one that is there already.
    void add(DeformationMethod method);

    /// Throws InputError for an unknown flag.
    const DeformationMethod& find(const std::string& flag) const;
    std::vector<std::string> flags() const;
    /// "flag: summary" of all, one after the other.
    std::string help() const;
    void add_options(Tool& tool) const;

private:
    std::vector<DeformationMethod> methods_;
};

}  // namespace ndg
